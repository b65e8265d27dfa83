#!/usr/bin/env bash
# Runs the demo on a short simulation with the programs of a build folder, and looks at what it
# leaves:  demo_test.sh BUILD_FOLDER
set -euo pipefail

demo=$(cd "$(dirname "${BASH_SOURCE[0]}")/../../.." && pwd)/apps/demo.sh
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
mkdir "$folder/tmp" "$folder/elsewhere"
export TMPDIR=$folder/tmp
cd "$folder/elsewhere"

fail() {
  echo "demo_test: $1" >&2
  [ ! -e "$folder/talk" ] || cat "$folder/talk" >&2
  exit 1
}

code=0
"$demo" sim:room:10 --no-setup --no-build --build-dir "$1" --rate 10 --wait \
  --camera azure-nfov-binned --out "$folder/result" >"$folder/talk" 2>&1 </dev/null || code=$?
[ "$code" -eq 0 ] || fail "the demo ended with $code"
grep -q "10 given, 0 dropped, 10 sent, 10 received whole, 0 incomplete, 0 lost" "$folder/talk" ||
  fail "the table does not count ten frames"
grep -Eq "max error .* of its bound, over 10 frames checked" "$folder/talk" ||
  fail "the table does not name the error"

# Signatures of the files, and sizes that hold a frame of 320 x 288.
[ "$(head -c 8 "$folder/result/side-by-side.png" | od -An -tx1 | tr -d ' \n')" = 89504e470d0a1a0a ] ||
  fail "the picture is not a PNG"
[ "$(tail -c 8 "$folder/result/side-by-side.png" | head -c 4)" = IEND ] || fail "the picture is cut"
vertices=$(sed -n '/^element vertex/{s/[^0-9]//gp;q}' "$folder/result/last-frame.ply")
header=$(grep -abo end_header "$folder/result/last-frame.ply" | head -n 1 | cut -d: -f1)
size=$(stat -c %s "$folder/result/last-frame.ply")
[ "$vertices" -gt 60000 ] || fail "the cloud has only $vertices points"
[ "$size" -eq $((header + 11 + 12 * vertices)) ] || fail "the cloud's size is not its points'"

# Mistakes end with their exit codes, and nothing is left behind.
[ -z "$(ls -A "$folder/tmp")" ] || fail "the demo left files behind"
code=0
"$demo" --no-setup --no-build --build-dir "$1" not-there >"$folder/talk" 2>&1 </dev/null || code=$?
[ "$code" -eq 3 ] || fail "a missing input ended with $code instead of 3"
code=0
"$demo" --tolerance >"$folder/talk" 2>&1 </dev/null || code=$?
[ "$code" -eq 2 ] || fail "an option without its value ended with $code instead of 2"
[ -z "$(ls -A "$folder/tmp")" ] || fail "the demo left files behind"
