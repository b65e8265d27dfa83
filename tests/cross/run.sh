#!/usr/bin/env bash
# Builds for other machines and compilers and runs the tests there: under qemu-user where the machine
# is not this one. Everywhere the golden vectors must decode to the same floats and encode to the same
# bytes.
set -euo pipefail

usage() {
  cat <<'TEXT'
usage: tests/cross/run.sh [--quick] [--build FOLDER] NAME...
  machines (cross compiler and qemu-user):
    aarch64 armhf      all of core; transport and the commands too, against a private package root
    riscv64 s390x      all of core (s390x is big-endian)
    cortex-a53 cortex-a72 cortex-a76    the golden vectors and the rooms that decide bytes and points
                       (base, model, predict, regen), compiled for that core, on an emulated one
  this machine:
    gcc-O0 gcc-O3 clang-O0 clang-O3     the golden vectors
    embedded           core without LCM, exceptions and RTTI
  --quick   the golden vectors alone; aarch64: base, model, predict and regen too
exit codes: 0 passed, 1 a build or a test failed, 2 wrong usage, 77 a compiler or qemu is missing
TEXT
}

cd "$(dirname "${BASH_SOURCE[0]}")/../.."
quick=no
base=build/cross
names=()
while [ $# -gt 0 ]; do
  case "$1" in
    --quick) quick=yes ;;
    --build) base=${2:?} && shift ;;
    -h | --help) usage; exit 0 ;;
    aarch64 | armhf | riscv64 | s390x | cortex-a53 | cortex-a72 | cortex-a76) names+=("$1") ;;
    gcc-O0 | gcc-O3 | clang-O0 | clang-O3 | embedded) names+=("$1") ;;
    *) echo "run.sh: unknown name '$1'" >&2; usage >&2; exit 2 ;;
  esac
  shift
done
[ ${#names[@]} -gt 0 ] || { usage >&2; exit 2; }
mkdir -p "$base"
base=$(cd "$base" && pwd)
jobs=${PLANECAST_JOBS:-$(nproc)}

need() {
  command -v "$1" >/dev/null && return
  echo "SKIPPED $name: $1 is not installed: toolchains/setup.sh $2"
  exit 77
}

# configure PRESET ARGUMENT...: into $build, quietly unless it fails.
configure() {
  local log
  log=$(cmake --preset "$1" -B "$build" -D PLANECAST_UNITY=ON --log-level=WARNING "${@:2}" 2>&1) || { echo "$log"; return 1; }
}

# build_and_test TARGET...: builds the programs, runs the ctest test of each.
build_and_test() {
  cmake --build "$build" -j "$jobs" --target "$@"
  local tests
  tests=$(printf '%s|' "${@%_test}")
  ctest --test-dir "$build" -j "$jobs" --output-on-failure -R "^(${tests%|})\$" --no-tests=error
}

# Every program of the tests that this build has.
all_tests() {
  cmake --build "$build" --target help | sed -nE 's/^([a-z_]+_test): phony$/\1/p' | sort
}

# machine TRIPLE EMULATOR [DEBIAN_ARCHITECTURE]: QEMU_CPU, when set, is what the emulator emulates.
machine() {
  need "$1-g++" --cross
  need "$2" --cross
  local root=()
  if [ "$quick" = no ] && [ -n "${3:-}" ]; then
    toolchains/cross/root.sh "$3" "$base/root-$3"
    root=(-D PLANECAST_CROSS_ROOT="$base/root-$3" -D PLANECAST_EMBEDDED=OFF)
  fi
  # The quick run shows that word size and byte order do not matter; half its time is the compiler's.
  # It has a folder of its own: the cache would keep its -O1 for a whole run.
  if [ "$quick" = yes ]; then
    build+=-quick
    local flags="-O1 -DNDEBUG"
    [[ $name != cortex-* ]] || flags+=" -mcpu=$name"
    root=(-D "CMAKE_CXX_FLAGS_RELEASE=$flags")
  fi
  configure "$name" "${root[@]}"
  if [ "$quick" = yes ]; then
    local targets=(golden_test)
    [ "$name" != aarch64 ] || targets+=(base_test model_test predict_test regen_test)
    build_and_test "${targets[@]}"
    return
  fi
  if [[ $name = cortex-* ]]; then
    build_and_test golden_test base_test model_test predict_test regen_test
    return
  fi
  build_and_test $(all_tests)
  [ ${#root[@]} -gt 0 ] || return 0
  cmake --build "$build" -j "$jobs" --target planecast planecastd planecast-recv
  local libraries=/usr/$1/lib:$base/root-$3/usr/lib/$1:$base/root-$3/lib/$1
  tests/cross/commands.sh "$build" "$(ls build/release/apps/planecast/planecast 2>/dev/null || true)" \
    timeout 300 "$2" -L "/usr/$1" -E "LD_LIBRARY_PATH=$libraries"
}

# One compiler at one level; the tests themselves are compiled the same way.
variant() {
  configure release -D PLANECAST_EMBEDDED=ON -D CMAKE_C_COMPILER="$1" -D CMAKE_CXX_COMPILER="$2" \
    -D CMAKE_CXX_FLAGS_RELEASE="$3"
  cmake --build "$build" -j "$jobs" --target golden_test
  "$build/tests/golden/golden_test" --gtest_brief=1
}

for name in "${names[@]}"; do
  build=$base/$name
  echo "== $name"
  case "$name" in
    aarch64) machine aarch64-linux-gnu qemu-aarch64-static arm64 ;;
    armhf) machine arm-linux-gnueabihf qemu-arm-static armhf ;;
    riscv64) machine riscv64-linux-gnu qemu-riscv64-static ;;
    s390x) machine s390x-linux-gnu qemu-s390x-static ;;
    cortex-*) QEMU_CPU=$name machine aarch64-linux-gnu qemu-aarch64-static ;;
    gcc-*) variant gcc g++ "-${name#gcc-}" ;;
    clang-*) need clang++ --fuzz && variant clang clang++ "-${name#clang-}" ;;
    embedded)
      configure embedded
      if [ "$quick" = yes ]; then
        cmake --build "$build" -j "$jobs" --target golden_test
        "$build/tests/golden/golden_test" --gtest_brief=1
      else
        cmake --build "$build" -j "$jobs" --target $(all_tests)
        cmake --build "$build" -j "$jobs" --target board_decode board_encode
        ctest --test-dir "$build" -j "$jobs" --output-on-failure --no-tests=error
        tests/embedded/sizes.sh --build "$base/sizes"
      fi
      ;;
  esac
done
