#!/usr/bin/env bash
# Frames at a sensor's rate through planecastd, LCM on loopback and planecast-recv: what arrived
# whole, what was dropped, and how long a frame took from memory to readable cloud.
#   bench/end_to_end.sh BUILD INPUT [codec options]      one row a tolerance: 0, 10mm, 2sigma
# TOLERANCES="2sigma 20mm" in the environment changes the rows; RATE (30; several: a row each, to see
# what is sustained) and FRAMES (all of the input, 120) the load. Frames are in memory before the
# start. Runs in a network namespace of its own, with the kernel's default buffers.
set -euo pipefail
export LC_ALL=C

if [ $# -lt 2 ]; then
  sed -n '2,8s/^# \{0,1\}//p' "$0"
  exit 2
fi
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
if [ "${PLANECAST_NETNS:-}" != 1 ]; then
  exec "$here/../tests/support/netns.sh" "$here/end_to_end.sh" "$@"
fi
build=$1
shift
frames=${FRAMES:-120}
temporary=$(mktemp -d)
daemon_pid=""
receiver_pid=""
clean() {
  [ -z "$daemon_pid" ] || kill "$daemon_pid" 2>/dev/null || true
  [ -z "$receiver_pid" ] || kill "$receiver_pid" 2>/dev/null || true
  rm -rf "$temporary"
}
trap clean EXIT

# field NAME LINE: the value of NAME=VALUE in a line; "-" where there is none.
field() {
  if [[ " $2 " =~ \ $1=([^ ]*)\  ]]; then echo "${BASH_REMATCH[1]}"; else echo "-"; fi
}

row="%-10s %5s %6s %8s %8s %8s %5s | %9s %9s %9s | %9s %8s\n"
# shellcheck disable=SC2059
printf "$row" tolerance rate sent complete partial dropped lost p50_ms p99_ms max_ms encode_ms Mbit/s
worst=0
for setting in $(for t in ${TOLERANCES:-0 10mm 2sigma}; do
  for r in ${RATE:-30}; do echo "$t@$r"; done
done); do
  tolerance=${setting%@*}
  rate=${setting#*@}
  "$build/apps/recv/planecast-recv" --frames "$frames" --streams 1 --max-size 1280x720 \
    --status "$temporary/r" --timeout 60 >/dev/null 2>"$temporary/r.log" &
  receiver_pid=$!
  until grep -q ready=1 "$temporary/r" 2>/dev/null; do sleep 0.05; done
  "$build/apps/planecastd/planecastd" "$@" --tolerance "$tolerance" --rate "$rate" \
    --preload "$frames" --status "$temporary/d" >/dev/null 2>"$temporary/d.log" &
  daemon_pid=$!
  wait "$daemon_pid" || worst=1
  daemon_pid=""
  for _ in $(seq 30); do
    kill -0 "$receiver_pid" 2>/dev/null || break
    sleep 0.1
  done
  kill -TERM "$receiver_pid" 2>/dev/null || true
  wait "$receiver_pid" || worst=1
  receiver_pid=""
  r=$(grep final=1 "$temporary/r" || true)
  d=$(grep ^frame= "$temporary/d" | tail -n 1)
  sent=$(sed -n 's/^ *frames out *\([0-9]*\).*/\1/p' "$temporary/d.log" | head -n 1)
  given=$(sed -n 's/^ *frames in *\([0-9]*\).*/\1/p' "$temporary/d.log" | head -n 1)
  # shellcheck disable=SC2059
  printf "$row" "$tolerance" "$rate" "$sent" "$(field complete "$r")" "$(field partial "$r")" \
    "$((given - sent))" "$(field lost "$r")" "$(field latency_p50_ms "$r")" \
    "$(field latency_p99_ms "$r")" "$(field latency_max_ms "$r")" "$(field encode_ms "$d")" \
    "$(field mbit_s "$d")"
  [ "$(field complete "$r")" = "$given" ] || worst=1
  rm -f "$temporary"/*
done
exit $worst
