#!/bin/sh
# Runs a command in a private network namespace whose loopback carries multicast, so that LCM works
# on any host and nothing leaves it:  netns.sh COMMAND [ARGUMENT...]
# Exits 77 (skipped, for ctest) with a reason when this host permits no namespaces.
set -u
if [ $# -eq 0 ]; then
  echo "usage: netns.sh COMMAND [ARGUMENT...]" >&2
  exit 2
fi

if [ "${PLANECAST_NETNS:-}" = 1 ]; then
  # Second run of this script, inside the namespace.
  if ! ip link set lo up || ! ip link set lo multicast on || ! ip route add 224.0.0.0/4 dev lo; then
    echo "netns.sh: skipped: the loopback of the namespace cannot be configured" >&2
    exit 77
  fi
  exec "$@"
fi

for tool in unshare ip; do
  if ! command -v "$tool" >/dev/null 2>&1; then
    echo "netns.sh: skipped: '$tool' is missing (Debian: apt-get install util-linux iproute2)" >&2
    exit 77
  fi
done
# Root needs only a network namespace; anyone else a user namespace around it.
if unshare -n true 2>/dev/null; then
  set -- unshare -n "$0" "$@"
elif unshare -rn true 2>/dev/null; then
  set -- unshare -rn "$0" "$@"
else
  echo "netns.sh: skipped: network namespaces are not permitted here" \
       "(as root: sysctl -w kernel.unprivileged_userns_clone=1, or run the tests as root)" >&2
  exit 77
fi
PLANECAST_NETNS=1 exec "$@"
