#!/usr/bin/env bash
# Builds core for a board (PLANECAST_EMBEDDED, -Os, unused sections left out) and states what it
# weighs: code and constants of the decoder and of the encoder without the system's libraries, and
# memory by size.
set -euo pipefail

usage() {
  cat <<'TEXT'
usage: tests/embedded/sizes.sh [--build FOLDER] [NAME...]
  NAME: host (default), aarch64, armhf, riscv64; the last three need toolchains/setup.sh --cross
  Prints two tables in Markdown, as in docs/embedded.md.
exit codes: 0 within the limits (decoder 200,000 bytes of code and constants and no Eigen, VGA encoder of 4 slots
  24,000,000 bytes), 1 beyond them or not built, 2 wrong usage, 77 a compiler is missing
TEXT
}

cd "$(dirname "${BASH_SOURCE[0]}")/../.."
base=build/sizes
names=()
while [ $# -gt 0 ]; do
  case "$1" in
    --build) base=${2:?} && shift ;;
    -h | --help) usage; exit 0 ;;
    host | aarch64 | armhf | riscv64) names+=("$1") ;;
    *) echo "sizes.sh: unknown name '$1'" >&2; usage >&2; exit 2 ;;
  esac
  shift
done
[ ${#names[@]} -gt 0 ] || names=(host)

triple() {
  case "$1" in
    host) echo "" ;;
    aarch64) echo aarch64-linux-gnu- ;;
    armhf) echo arm-linux-gnueabihf- ;;
    riscv64) echo riscv64-linux-gnu- ;;
  esac
}

# section_bytes PREFIX PROGRAM NAME...: the sum of these sections.
section_bytes() {
  local sections
  sections=$("$1size" -A "$2")
  shift 2
  local sum=0 name bytes
  for name in "$@"; do
    bytes=$(awk -v n="$name" '$1 == n { print $2 }' <<<"$sections")
    sum=$((sum + ${bytes:-0}))
  done
  echo "$sum"
}

failed=0
say_failed() { echo "sizes.sh: FAILED: $1" >&2; failed=1; }

echo "| machine | program | code | constants | both | other data | unwind tables |"
echo "|---|---|---|---|---|---|---|"
for name in "${names[@]}"; do
  prefix=$(triple "$name")
  command -v "${prefix}g++" >/dev/null || { echo "SKIPPED: ${prefix}g++ is missing: toolchains/setup.sh --cross" >&2; exit 77; }
  preset=$([ "$name" = host ] && echo embedded || echo "$name")
  build=$base/$name
  cmake --preset "$preset" -B "$build" --log-level=WARNING -D CMAKE_BUILD_TYPE=MinSizeRel \
    -D PLANECAST_EMBEDDED=ON >/dev/null
  cmake --build "$build" -j "${PLANECAST_JOBS:-$(nproc)}" --target board_decode board_encode >"$build/log" 2>&1 ||
    { tail -20 "$build/log" >&2; exit 1; }
  for program in board_decode board_encode; do
    file=$build/tests/embedded/$program
    code=$(section_bytes "$prefix" "$file" .text)
    constants=$(section_bytes "$prefix" "$file" .rodata)
    both=$((code + constants))
    echo "| $name | $program | $code | $constants | $both | $(section_bytes "$prefix" "$file" .data .bss .data.rel.ro) |" \
      "$(section_bytes "$prefix" "$file" .eh_frame .eh_frame_hdr .gcc_except_table .ARM.extab .ARM.exidx) |"
    [ "$program" = board_encode ] || [ "$both" -le 200000 ] ||
      say_failed "the decoder has $both bytes of code and constants"
  done
  # Names of templates begin with what they are of: N5Eigen in mangled form.
  ! "${prefix}nm" "$build/tests/embedded/board_decode" | grep -q 5Eigen || say_failed "the decoder holds Eigen"
done

# Memory is the same everywhere but for the width of pointers; printed by this machine's program.
[ "${names[0]}" = host ] || exit $failed
echo
echo "| size | encoder, 4 slots | decoder | packed, 10 mm | resident at most |"
echo "|---|---|---|---|---|"
while read -r width height encoder decoder packed resident; do
  echo "| ${width}x$height | $encoder | $decoder | $packed | $resident kB |"
  [ "$width" != 640 ] || [ "$encoder" -le 24000000 ] || say_failed "the VGA encoder takes $encoder bytes"
done < <("$base/host/tests/embedded/board_encode")
exit $failed
