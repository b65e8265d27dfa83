#!/usr/bin/env bash
# Builds the fuzz targets with clang (libFuzzer, address and undefined behaviour sanitizers) and runs
# them one after the other. What they find new is kept in the build folder's corpus.
set -euo pipefail

usage() {
  cat <<'TEXT'
usage: tests/fuzz/run.sh [--seconds N] [--executions N] [--build FOLDER] [TARGET...]
  Fuzzes every target for 30 seconds each, or those named, for so long or so often as told;
  with both, until the first of them is reached.
  targets: kitti_bin depth_png ply pcd xyz_text key file patch slice
exit codes: 0 no fault, 1 a fault (its input is named) or a failed build, 2 wrong usage,
  77 clang or libFuzzer is not installed
TEXT
}

cd "$(dirname "${BASH_SOURCE[0]}")/../.."
build=build/fuzz
limits=()
targets=()
while [ $# -gt 0 ]; do
  case "$1" in
    --seconds) limits+=(-max_total_time="${2:?}") && shift ;;
    --executions) limits+=(-runs="${2:?}") && shift ;;
    --build) build=${2:?} && shift ;;
    -h | --help) usage; exit 0 ;;
    -*) echo "run.sh: unknown option '$1'" >&2; usage >&2; exit 2 ;;
    *) targets+=("$1") ;;
  esac
  shift
done
[ ${#limits[@]} -gt 0 ] || limits=(-max_total_time=30)
[ ${#targets[@]} -gt 0 ] || targets=(kitti_bin depth_png ply pcd xyz_text key file patch slice)

if ! echo 'extern "C" int LLVMFuzzerTestOneInput(const char*, unsigned long) { return 0; }' |
  clang++ -x c++ -fsanitize=fuzzer,address -o /dev/null - 2>/dev/null; then
  echo "SKIPPED: clang with libFuzzer is not installed: toolchains/setup.sh --fuzz"
  exit 77
fi

cmake --preset fuzz -B "$build" --log-level=WARNING >/dev/null
cmake --build "$build" -j "${PLANECAST_JOBS:-$(nproc)}" --target make_corpus "${targets[@]/%/_fuzz}"
folder=$build/tests/fuzz

# A try costs what its input holds: short ones give more of them, and say the same.
longest() {
  case "$1" in
    kitti_bin) echo 128 ;;
    patch) echo 256 ;;
    slice | pcd | ply | xyz_text) echo 384 ;;
    *) echo 640 ;;
  esac
}

# A try allocates a few dozen times: a short quarantine and short stacks of allocations cost less.
# Leaks are what the same targets are replayed for in ctest.
export ASAN_OPTIONS=quarantine_size_mb=8:malloc_context_size=4:detect_leaks=0
"$folder/make_corpus" "$folder/corpus"
failed=0
for target in "${targets[@]}"; do
  found=tests/fuzz/found/$target
  [ -d "$found" ] || found=
  log=$folder/$target.log
  # The time is of the wall, and the process may have been held up: a loop is what takes minutes.
  if "$folder/${target}_fuzz" "${limits[@]}" -max_len="$(longest "$target")" -timeout=120 \
    -rss_limit_mb=3000 -entropic=0 -print_final_stats=1 -artifact_prefix="$folder/$target-" "$folder/corpus/$target" $found >"$log" 2>&1; then
    printf '%-10s %10s executions, %6s a second, %5s edges, no fault\n' "$target" \
      "$(sed -n 's/.*number_of_executed_units: *//p' "$log")" \
      "$(sed -n 's/.*average_exec_per_sec: *//p' "$log")" \
      "$(sed -n 's/.* cov: \([0-9]*\) .*/\1/p' "$log" | tail -n 1)"
  else
    failed=1
    echo "$target FAILED; the input: $(sed -n 's/.*Test unit written to //p' "$log"), the report: $log"
  fi
done
exit $failed
