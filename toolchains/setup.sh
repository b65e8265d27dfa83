#!/usr/bin/env bash
# Installs the Debian 12 packages that Planecast needs; packages that are there are left alone.
# Asks nothing, prints what it does, may be run again at any time.
set -euo pipefail

usage() {
  cat <<'TEXT'
usage: toolchains/setup.sh [--bench] [--pcl] [--fuzz] [--cross] [--print]
  Installs what is missing of the packages that building and testing need (Debian 12).
  --bench   also the codecs that the benchmarks compare with
  --pcl     also PCL and CGAL (over 400 packages): the paper's chain and hulls beside theirs
  --fuzz    also clang with libFuzzer
  --cross   also the cross compilers for 32-bit ARM and RISC-V
  --print   only print the packages, one a line, and change nothing
exit codes: 0 everything is there, 1 something could not be installed, 2 wrong usage
TEXT
}

packages=(
  # build
  g++ cmake ninja-build pkg-config ca-certificates
  # core
  libeigen3-dev       # fits in the encoder, metrics
  libnanoflann-dev    # nearest neighbours of the reference path and the metrics
  libspng-dev         # 16-bit depth PNG in, pictures out
  # transport
  liblcm-dev          # the LCM library
  liblcm-bin          # lcm-gen: the tests compare our packet code with its own
  # apps
  libcli11-dev        # command lines
  libtomlplusplus-dev # planecastd's configuration file
  libfmt-dev          # talk on standard error
  nlohmann-json3-dev  # --json
  # tests
  libgtest-dev librapidcheck-dev
  libbenchmark-dev    # bench/
  relacy-dev          # tests/core/ring/model: the rings in every order the memory model permits
  spin                # tests/core/pipeline/model: the whole pipeline, all its states
  python3-minimal     # tests/house
  iproute2 util-linux # private network namespaces for LCM tests and apps/demo.sh (ip, unshare)
  googletest          # its sources, to build the tests for other machines
  # tests/cross: the golden vectors on a board's processor and on a big-endian one (150 MB to fetch)
  g++-aarch64-linux-gnu g++-s390x-linux-gnu qemu-user-static
)
bench_packages=(libboost-dev libreaderwriterqueue-dev libdraco-dev libbz2-dev libzstd-dev libcharls-dev libopenjp2-7-dev liblzma-dev libpng-dev)
pcl_packages=(libpcl-dev libcgal-dev)
fuzz_packages=(clang libclang-rt-14-dev)
cross_packages=(g++-arm-linux-gnueabihf g++-riscv64-linux-gnu)

print_only=no
for argument in "$@"; do
  case "$argument" in
    --bench) packages+=("${bench_packages[@]}") ;;
    --pcl) packages+=("${pcl_packages[@]}") ;;
    --fuzz) packages+=("${fuzz_packages[@]}") ;;
    --cross) packages+=("${cross_packages[@]}") ;;
    --print) print_only=yes ;;
    -h | --help) usage; exit 0 ;;
    *) echo "setup.sh: unknown option '$argument'" >&2; usage >&2; exit 2 ;;
  esac
done

if [ "$print_only" = yes ]; then
  printf '%s\n' "${packages[@]}"
  exit 0
fi

if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
  echo "setup.sh: this is not a Debian system (no dpkg-query or apt-get); install by hand the like of:" >&2
  echo "  ${packages[*]}" >&2
  exit 1
fi

# dpkg-query says "ii" for what is installed and complete; anything else counts as missing.
missing=()
for package in "${packages[@]}"; do
  state=$(dpkg-query -W -f '${db:Status-Abbrev}\n' "$package" 2>/dev/null || true)
  case "$state" in
    *ii*) ;;
    *) missing+=("$package") ;;
  esac
done

if [ ${#missing[@]} -eq 0 ]; then
  echo "setup.sh: all ${#packages[@]} packages are installed"
  exit 0
fi

install=(apt-get install -y --no-install-recommends "${missing[@]}")
root=()
if [ "$(id -u)" -ne 0 ]; then
  if command -v sudo >/dev/null && sudo -n true 2>/dev/null; then
    root=(sudo -n)
  else
    echo "setup.sh: ${#missing[@]} packages are missing and this user may not install them. Run:" >&2
    echo "  sudo apt-get update && sudo ${install[*]}" >&2
    exit 1
  fi
fi
echo "setup.sh: installing ${missing[*]}"

# apt-get through root when needed; never a question, and patient with another apt's lock.
apt() {
  "${root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -o DPkg::Lock::Timeout=120 \
    -o APT::Get::Assume-Yes=true "$@" </dev/null
}

# The package lists are fetched only when they cannot serve the request as they are.
if ! { apt-get install --simulate --no-install-recommends "${missing[@]}" >/dev/null 2>&1 &&
       apt install --no-install-recommends "${missing[@]}"; }; then
  echo "setup.sh: updating the package lists"
  if ! apt update || ! apt install --no-install-recommends "${missing[@]}"; then
    echo "setup.sh: apt could not install the packages; look at its messages above, then run:" >&2
    echo "  sudo apt-get update && sudo ${install[*]}" >&2
    exit 1
  fi
fi
echo "setup.sh: installed ${#missing[@]} packages, ${#packages[@]} in all"
