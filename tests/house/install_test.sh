#!/usr/bin/env bash
# Installs a build into an empty folder and lets a project outside the tree find, link and run it.
# usage: install_test.sh BUILD_FOLDER
set -euo pipefail
build=$(cd "$1" && pwd)
consumer=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)/consumer
place=$(mktemp -d)
trap 'rm -r "$place"' EXIT

cmake --install "$build" --component development --prefix "$place/prefix" >"$place/log" || {
  cat "$place/log"
  exit 1
}
cp -r "$consumer" "$place/consumer"
cmake -S "$place/consumer" -B "$place/build" -G Ninja -DCMAKE_BUILD_TYPE=Release \
  -DCMAKE_PREFIX_PATH="$place/prefix" --log-level=WARNING
cmake --build "$place/build"
"$place/build/consumer"

# Nothing that was installed may lead back to the tree it was built in.
source=$(cd "$consumer/../../.." && pwd)
if grep -rlF -e "$source/" -e "$build/" "$place/prefix" --include='*.cmake'; then
  echo "the CMake package above names folders of the build machine"
  exit 1
fi
