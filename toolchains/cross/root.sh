#!/usr/bin/env bash
# Makes a private package root: the libraries of another architecture, unpacked into a folder. The
# computer's own packages and apt settings stay as they are (liblcm of two architectures conflict,
# and an added architecture can break the next apt-get update).
set -euo pipefail

usage() {
  cat <<'TEXT'
usage: toolchains/cross/root.sh ARCH FOLDER
  ARCH: arm64 or armhf (riscv64 is no part of Debian 12). FOLDER is created; a complete one is kept.
  Then: cmake --preset aarch64 -D PLANECAST_CROSS_ROOT=FOLDER
exit codes: 0 done, 1 packages could not be fetched, 2 wrong usage
TEXT
}
[ $# -eq 2 ] || { usage >&2; exit 2; }
case "$1" in arm64 | armhf) ;; *) usage >&2; exit 2 ;; esac
arch=$1
mkdir -p "$2"
folder=$(cd "$2" && pwd)
[ ! -e "$folder/complete" ] || exit 0

packages=(
  liblcm1 liblcm-dev libglib2.0-0 libpcre2-8-0            # transport
  libspng0 libspng-dev zlib1g                             # PNG
  libfmt9 libfmt-dev libtomlplusplus3 libtomlplusplus-dev # commands
  librapidcheck-dev                                       # tests
)

state=$folder/apt
mkdir -p "$state/lists/partial" "$state/archives/partial" "$state/sources"
: >"$state/status"
export DEBIAN_FRONTEND=noninteractive
apt=(apt-get -o Dir::State="$state" -o Dir::State::Lists="$state/lists" -o Dir::State::status="$state/status"
  -o Dir::Cache="$state" -o Dir::Cache::Archives="$state/archives" -o Dir::Etc::sourcelist="$state/sources/debian.list"
  -o Dir::Etc::sourceparts=/dev/null -o APT::Architecture="$arch" -o APT::Architectures="$arch"
  -o Debug::NoLocking=1 -o APT::Sandbox::User=root)

# The computer's own mirror, its main suite alone: other suites' indexes may lag behind for a port.
mirror=$(grep -rhoE 'https?://[^ ]*/debian/?( |$)' /etc/apt/sources.list /etc/apt/sources.list.d 2>/dev/null |
  head -1 | tr -d ' ') || true
suite=$(. /etc/os-release && echo "$VERSION_CODENAME")
keys=/usr/share/keyrings/debian-archive-keyring.gpg
echo "deb [signed-by=$keys] ${mirror:-http://deb.debian.org/debian} $suite main" \
  >"$state/sources/debian.list"

if ! "${apt[@]}" -qq update || ! (cd "$state/archives" && "${apt[@]}" -qq download "${packages[@]}"); then
  echo "root.sh: the $arch packages could not be fetched; look at apt's messages above" >&2
  exit 1
fi
for package in "$state"/archives/*.deb; do dpkg-deb -x "$package" "$folder"; done
rm -r "$state"
touch "$folder/complete"
echo "root.sh: ${#packages[@]} $arch packages in $2 ($(du -sh "$folder" | cut -f1))"
