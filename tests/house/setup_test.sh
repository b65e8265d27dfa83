#!/usr/bin/env bash
# Runs toolchains/setup.sh against stand-ins for dpkg-query, apt-get, id and sudo: what it installs,
# when it updates the lists, and what it says when it may not install.
set -euo pipefail
setup=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)/toolchains/setup.sh
stubs=$(mktemp -d)
trap 'rm -r "$stubs"' EXIT

stub() { printf '#!/bin/sh\n%s\n' "$2" >"$stubs/$1" && chmod +x "$stubs/$1"; }
fail() { echo "FAILED: $1"; cat "$stubs/out" "$stubs/apt.log"; exit 1; }

# run WANTED_CODE: setup.sh with the stand-ins first in the path; output in out, apt's calls in apt.log
run() {
  local wanted=$1 code=0
  shift
  : >"$stubs/apt.log"
  STUBS=$stubs PATH=$stubs:$PATH "$setup" "$@" >"$stubs/out" 2>&1 </dev/null || code=$?
  [ "$code" = "$wanted" ] || fail "exit code $code instead of $wanted"
}
has() { grep -q -- "$2" "$stubs/$1" || fail "no '$2' in $1"; }
has_not() { ! grep -q -- "$2" "$stubs/$1" || fail "'$2' in $1"; }

all_installed='echo "ii "'
spng_missing='case "$*" in *libspng-dev*) exit 1 ;; *) echo "ii " ;; esac'
stub sudo 'exit 1'
stub id 'echo 0'
stub apt-get 'echo "$*" >>"$STUBS/apt.log"'

stub dpkg-query "$all_installed"
run 0
has out "packages are installed"
has_not apt.log .

stub dpkg-query "$spng_missing"
run 0
has apt.log "install --no-install-recommends libspng-dev\$"
has_not apt.log update
has_not apt.log libeigen3-dev

# Half-installed or removed-but-configured counts as missing.
stub dpkg-query 'case "$*" in *libspng-dev*) echo "rc " ;; *) echo "ii " ;; esac'
run 0
has apt.log libspng-dev

# Lists that do not know the package are updated once, then it is installed.
stub dpkg-query "$spng_missing"
stub apt-get 'echo "$*" >>"$STUBS/apt.log"
case "$*" in *update*) touch "$STUBS/updated" ;; *) [ -e "$STUBS/updated" ] ;; esac'
run 0
has apt.log update
has out "updating the package lists"

stub apt-get 'echo "$*" >>"$STUBS/apt.log"; exit 100'
run 1
has out "sudo apt-get update && sudo apt-get install -y --no-install-recommends libspng-dev"

# Neither root nor sudo without a password: the exact command, and no attempt.
stub id 'echo 1000'
run 1
has out "sudo apt-get update && sudo apt-get install -y --no-install-recommends libspng-dev"
has_not apt.log .

stub sudo 'shift; exec "$@"'
stub apt-get 'echo "$*" >>"$STUBS/apt.log"'
run 0
has apt.log libspng-dev

stub dpkg-query 'case "$*" in *libdraco-dev* | *libclang-rt-14-dev*) exit 1 ;; *) echo "ii " ;; esac'
run 0 --bench --fuzz --cross
has apt.log libdraco-dev
has apt.log libclang-rt-14-dev
run 2 --no-such-option
echo "setup.sh: every case as it should be"
