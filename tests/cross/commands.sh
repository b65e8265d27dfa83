#!/usr/bin/env bash
# The commands of a cross build, in the emulator: a stream made there is decoded there and here, and a
# daemon there is received there, over LCM.
#   commands.sh BUILD HOST_PLANECAST-OR-EMPTY EMULATOR...
set -euo pipefail
build=$(cd "$1" && pwd)
host=$2
shift 2
emulator=("$@")
support=$(cd "$(dirname "${BASH_SOURCE[0]}")/../support" && pwd)
work=$(mktemp -d)
trap 'rm -r "$work"' EXIT

fail() { echo "commands.sh: FAILED: $1" >&2; exit 1; }
board() { local program=$1; shift; "${emulator[@]}" "$build/apps/$program" "$@"; }

echo "-- encode, decode, eval"
board planecast/planecast encode sim:room:2 -o "$work/room.plc" --tolerance 2sigma
board planecast/planecast decode "$work/room.plc" -o "$work/there" >"$work/decoded.txt"
board planecast/planecast eval sim:room:1 --tolerance 10mm >"$work/eval.txt" || fail "eval ends with $?"
if [ -n "$host" ]; then
  "$host" decode "$work/room.plc" -o "$work/here" >/dev/null
  diff -r "$work/here" "$work/there" || fail "clouds decoded there and here differ"
  echo "   $(ls "$work/here" | wc -l) files decoded there and here are the same"
fi

echo "-- daemon and receiver over LCM"
cat >"$work/stream.sh" <<EOF2
set -e
cd "$work"
$(printf '%q ' "${emulator[@]}") $build/apps/planecastd/planecastd sim:room:6 --rate 1 --tolerance 2sigma >sent.txt 2>&1 &
$(printf '%q ' "${emulator[@]}") $build/apps/recv/planecast-recv --frames 3 --timeout 120 >received.txt 2>&1
wait
EOF2
code=0
"$support/netns.sh" bash "$work/stream.sh" || code=$?
if [ $code -eq 77 ]; then
  echo "   skipped: no network namespace here"
elif [ $code -ne 0 ]; then
  cat "$work/sent.txt" "$work/received.txt"
  fail "the stream ends with $code"
fi
tail -3 "$work/received.txt" 2>/dev/null || true
