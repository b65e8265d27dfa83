#!/usr/bin/env bash
# Sets up, builds and runs every test; ends in ctest's own summary of the release build.
# Sanitizer builds go first, so that a memory error or a race stops the run at once.
set -euo pipefail

usage() {
  cat <<'TEXT'
usage: tests/run.sh [--quick] [--no-setup]
  Sets up, builds and runs every test: address+undefined and thread sanitizers, then release.
  --quick      release build only
  --no-setup   do not look for missing packages
  PLANECAST_JOBS=N in the environment: parallel jobs (default: the number of processors)
exit codes: 0 every test passed, 1 a test, a build or the set-up failed, 2 wrong usage
TEXT
}

quick=no
setup=yes
for argument in "$@"; do
  case "$argument" in
    --quick) quick=yes ;;
    --no-setup) setup=no ;;
    -h | --help) usage; exit 0 ;;
    *) echo "run.sh: unknown option '$argument'" >&2; usage >&2; exit 2 ;;
  esac
done

cd "$(dirname "${BASH_SOURCE[0]}")/.."
exec </dev/null
jobs=${PLANECAST_JOBS:-$(nproc)}
started=$SECONDS
wrap=()
step=start

# Any failure ends the run with 1. After the last step ctest's summary is the last word.
finish() {
  local code=$?
  [ $code -eq 0 ] && return
  [ "$step" = "release: test" ] || echo "run.sh: FAILED at '$step'" >&2
  exit 1
}
trap finish EXIT

say() {
  step=$1
  printf '\n== %s (%d s)\n' "$step" $((SECONDS - started))
}

# build_and_test PRESET: configures, builds and tests one preset of CMakePresets.json.
build_and_test() {
  say "$1: configure"
  "${wrap[@]}" cmake --preset "$1" -D PLANECAST_UNITY=ON --log-level=WARNING
  say "$1: build"
  "${wrap[@]}" cmake --build --preset "$1" -j "$jobs"
  say "$1: test"
  "${wrap[@]}" ctest --preset "$1" -j "$jobs"
}

# ThreadSanitizer needs a predictable memory map. Where the kernel randomises too much of it, its
# programs run under setarch -R. Answers in `wrap`; fails when neither way works.
find_tsan_wrap() {
  local probe
  probe=$(mktemp -d)
  echo 'int main() { return 0; }' >"$probe/probe.cpp"
  c++ -fsanitize=thread -o "$probe/probe" "$probe/probe.cpp"
  wrap=()
  local works=yes
  if ! "$probe/probe" >/dev/null 2>&1; then
    wrap=(setarch "$(uname -m)" -R)
    "${wrap[@]}" "$probe/probe" >/dev/null 2>&1 || works=no
  fi
  rm -r "$probe"
  [ "$works" = yes ]
}

if [ "$setup" = yes ]; then
  say "set-up"
  toolchains/setup.sh
fi

if [ "$quick" = no ]; then
  build_and_test asan-ubsan
  say "tsan: probe"
  if ! find_tsan_wrap; then
    echo "run.sh: ThreadSanitizer does not start on this kernel (vm.mmap_rnd_bits=$(
      cat /proc/sys/vm/mmap_rnd_bits 2>/dev/null || echo unknown)); allow it with:" >&2
    echo "  sudo sysctl vm.mmap_rnd_bits=28" >&2
    echo "or leave the sanitizers out with: tests/run.sh --quick" >&2
    exit 1
  fi
  build_and_test tsan
  wrap=()
fi
build_and_test release
