#!/usr/bin/env bash
# The main job, live: a daemon packs depth frames and sends them over LCM, a receiver regenerates
# the clouds and compares every point with the original. Sets up, builds, runs, and ends in a table,
# a cloud and a picture. Asks nothing; works from any folder.
set -euo pipefail
export LC_ALL=C

usage() {
  cat <<'TEXT'
usage: apps/demo.sh [INPUT] [options]
  Streams INPUT from planecastd to planecast-recv over LCM and checks every received point.
  INPUT           a folder of depth images or clouds, a file, or sim:room[:FRAMES]
                  (default: sim:room:100 played 3 times, ten seconds at 30 Hz)
  --out FOLDER    where the cloud and the picture go (default: ./planecast-demo)
  --wait          replay without loss: the source waits where the computer is too slow
  --build-dir D   build in D (default: build/release)
  --no-setup      do not look for missing packages
  --no-build      use the programs in the build folder as they are
  Every option of planecastd that says how to read, code and send is passed on, for example
    apps/demo.sh recording/ --camera 525,525,319.5,239.5 --noise kinect1 --tolerance 10mm
  ('planecastd --help' lists them; the default is --tolerance 2sigma).
  Where this computer is too busy for the input's rate, frames are dropped and counted as a camera's
  would be, and the demo runs once more at 10 Hz (not with --rate).
  Where this computer has no multicast route, the demo runs in a network of its own.
  PLANECAST_JOBS=N in the environment: parallel jobs of the build
exit codes: 0 every frame arrived whole and within its bound, 1 one did not, or a step failed,
            2 wrong usage, 3 unreadable input, 4 network not usable, 5 a bound exceeded
TEXT
}

die() {
  echo "demo.sh: $1" >&2
  exit "${2:-1}"
}

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
arguments=("$@")
input=""
out=planecast-demo
build=$root/build/release
preset=yes
setup=yes
compile=yes
daemon_options=()
options=()
tolerance=""
repeat=""

# need OPTION [VALUE]: the value that must follow an option.
need() {
  [ $# -ge 2 ] || die "$1 needs a value; see apps/demo.sh --help" 2
}

while [ $# -gt 0 ]; do
  case "$1" in
    -h | --help) usage; exit 0 ;;
    --no-setup) setup=no ;;
    --no-build) compile=no ;;
    --wait | --mlock) daemon_options+=("$1") ;;
    --out) need "$@"; out=$2; shift ;;
    --out=*) out=${1#*=} ;;
    --build-dir) need "$@"; build=$2; preset=no; shift ;;
    --build-dir=*) build=${1#*=}; preset=no ;;
    --preload | --stream) need "$@"; daemon_options+=("$1" "$2"); shift ;;
    --preload=* | --stream=*) daemon_options+=("$1") ;;
    --*=*) options+=("$1") ;;
    --*) need "$@"; options+=("$1" "$2"); shift ;;
    -*) die "unknown option '$1'; see apps/demo.sh --help" 2 ;;
    *)
      [ -z "$input" ] || die "one INPUT at a time: '$input' or '$1'" 2
      input=$1
      ;;
  esac
  shift
done

# The value of --NAME among the options that are passed on; "" where it was not given.
given() {
  local i
  for ((i = 0; i < ${#options[@]}; ++i)); do
    case "${options[i]}" in
      "--$1") echo "${options[i + 1]}"; return ;;
      "--$1="*) echo "${options[i]#*=}"; return ;;
    esac
  done
}

tolerance=$(given tolerance)
repeat=$(given repeat)
if [ -z "$tolerance" ]; then
  tolerance=2sigma
  [ "$(given method)" = paper ] && tolerance=surfaces
  options+=(--tolerance "$tolerance")
fi
if [ -z "$input" ]; then
  input=sim:room:100
  [ -n "$repeat" ] || { repeat=3; options+=(--repeat 3); }
fi

planecastd=$build/apps/planecastd/planecastd
receiver=$build/apps/recv/planecast-recv

# Set-up and build happen outside the private network, which has no way to the package archive.
if [ "${PLANECAST_DEMO_INSIDE:-}" != 1 ]; then
  [ "$setup" = no ] || "$root/toolchains/setup.sh" </dev/null
  if [ "$compile" = yes ]; then
    jobs=${PLANECAST_JOBS:-$(nproc)}
    echo "demo.sh: building in $build"
    if [ "$preset" = yes ]; then
      (cd "$root" && cmake --preset release --log-level=WARNING >/dev/null)
    elif [ ! -e "$build/CMakeCache.txt" ]; then
      cmake -S "$root" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release --log-level=WARNING >/dev/null
    fi
    cmake --build "$build" -j "$jobs" --target planecast planecastd planecast-recv </dev/null |
      tail -n 1
  fi
fi
for program in "$planecastd" "$receiver"; do
  [ -x "$program" ] || die "$program is not there; build it, or leave out --no-build"
done

# A host without a multicast route gets a network namespace that lives as long as the demo.
if [ "${PLANECAST_DEMO_INSIDE:-}" != 1 ] && ! ip route get 239.255.76.67 >/dev/null 2>&1; then
  netns=$root/tests/support/netns.sh
  export PLANECAST_DEMO_INSIDE=1
  echo "demo.sh: no multicast route here; using a private network namespace"
  if unshare -n true 2>/dev/null || unshare -rn true 2>/dev/null; then
    exec "$netns" "${BASH_SOURCE[0]}" "${arguments[@]}"
  fi
  if command -v sudo >/dev/null && sudo -n true 2>/dev/null; then
    exec sudo -n --preserve-env "$netns" setpriv --reuid="$(id -u)" --regid="$(id -g)" \
      --init-groups "${BASH_SOURCE[0]}" "${arguments[@]}"
  fi
  die "this host has no multicast route and permits no network namespaces; give it a route with
  sudo ip link set lo multicast on && sudo ip route add 224.0.0.0/4 dev lo" 4
fi

mkdir -p "$out" || die "the folder $out cannot be made"
cloud=$out/last-frame.ply
picture=$out/side-by-side.png
rm -f "$cloud" "$picture"
temporary=$(mktemp -d)
daemon_pid=""
receiver_pid=""
interrupted=no

# stop PID: ends one of our two programs and waits for it.
stop() {
  [ -n "$1" ] || return 0
  kill -TERM "$1" 2>/dev/null || true
  wait "$1" 2>/dev/null || true
}
clean() {
  stop "$daemon_pid"
  stop "$receiver_pid"
  rm -rf "$temporary"
}
interrupt() {
  interrupted=yes
  [ -z "$daemon_pid" ] || kill -INT "$daemon_pid" 2>/dev/null || true
  [ -n "$daemon_pid" ] || exit 130
}
trap clean EXIT
trap interrupt INT TERM
set -m # a process group each: Ctrl-C reaches this script, which ends them in order

# field NAME LINE: the value of NAME=VALUE in a line; "-" where there is none.
field() {
  if [[ " $2 " =~ \ $1=([^ ]*)\  ]] && [ "${BASH_REMATCH[1]}" != nan ]; then
    echo "${BASH_REMATCH[1]}"
  else
    echo "-"
  fi
}
# last FILE PATTERN: its last line that begins like the pattern.
last() {
  [ ! -e "$1" ] || grep -E "^$2" "$1" | tail -n 1 || true
}
alive() {
  kill -0 "$1" 2>/dev/null
}

received=$temporary/receiver.status
sent=$temporary/daemon.status
echo "demo.sh: $input${repeat:+ x $repeat}, tolerance $tolerance; loading the original to compare with"
"$receiver" --reference "$input" "${options[@]}" --status "$received" --last "$cloud" \
  --picture "$picture" --streams 1 --timeout 120 >/dev/null 2>"$temporary/receiver.log" &
receiver_pid=$!
while alive "$receiver_pid" && [ -z "$(last "$received" ready=1)" ]; do sleep 0.1; done

if alive "$receiver_pid"; then
  "$planecastd" "$input" "${options[@]}" "${daemon_options[@]}" --status "$sent" \
    >/dev/null 2>"$temporary/daemon.log" &
  daemon_pid=$!
fi

columns="%8s %6s %9s %9s %9s %7s %10s %11s %12s %6s\n"
lines=0
shown=""
# One line for each new one of the receiver, with what the daemon said last.
show() {
  local d r
  d=$(last "$sent" frame=)
  r=$(last "$received" t=)
  [ -n "$d" ] && [ -n "$r" ] && [ "$r" != "$shown" ] && [ "$(field hz "$r")" != 0.00 ] || return 0
  shown=$r
  if [ $((lines++ % 20)) -eq 0 ]; then
    # shellcheck disable=SC2059
    printf "$columns" frame Hz surfaces "raw kB" "packed kB" Mbit/s "encode ms" "latency ms" \
      error/bound lost
  fi
  local kilo='BEGIN { printf "%.1f", x / 1000 }'
  # shellcheck disable=SC2059
  printf "$columns" "$(field frame "$r")" "$(field hz "$r")" "$(field surfaces "$r")" \
    "$(awk -v x="$(field raw_bytes "$d")" "$kilo")" \
    "$(awk -v x="$(field packed_bytes "$d")" "$kilo")" "$(field mbit_s "$d")" \
    "$(field encode_ms "$d")" "$(field latency_p50_ms "$r")" "$(field max_error_ratio "$r")" \
    "$(field lost "$r")"
}

daemon_code=0
receiver_code=0
if [ -n "$daemon_pid" ]; then
  while alive "$daemon_pid"; do
    sleep 0.2 || true
    show
  done
  wait "$daemon_pid" || daemon_code=$?
  daemon_pid=""
fi

# balance NAME: a number of the table that planecastd ends in.
balance() {
  [ -e "$temporary/daemon.log" ] || return 0
  sed -n "s/^ *$1 *\([0-9][0-9]*\).*/\1/p" "$temporary/daemon.log" | head -n 1
}
frames_in=$(balance "frames in")
frames_out=$(balance "frames out")
: "${frames_in:=0}" "${frames_out:=0}"

# What was sent last is still on its way: wait until it is there, or nothing comes any more.
patience=$((SECONDS + 60))
while alive "$receiver_pid" && [ $SECONDS -lt $patience ] && [ "$daemon_code" -eq 0 ]; do
  line=$(last "$received" t=)
  [ "$(field frames "$line" | tr - 0)" -lt "$frames_out" ] || break
  [ "$(tail -n 2 "$received" | grep -c 'hz=0\.00')" -lt 2 ] || break
  sleep 0.1 || true
done
kill -TERM "$receiver_pid" 2>/dev/null || true
wait "$receiver_pid" || receiver_code=$?
receiver_pid=""
show

r=$(last "$received" final=1)
if [ -z "$r" ] || [ "$daemon_code" -ne 0 ]; then
  sed 's/^/  /' "$temporary/receiver.log" >&2
  [ ! -e "$temporary/daemon.log" ] || sed 's/^/  /' "$temporary/daemon.log" >&2
fi
[ -e "$temporary/daemon.log" ] || die "the receiver did not start" "$receiver_code"
[ "$daemon_code" -eq 0 ] || die "planecastd ended with $daemon_code" "$daemon_code"
[ -n "$r" ] || die "no frame arrived"

encode=$(grep -E '^frame=' "$sent" | sed 's/.*encode_ms=\([0-9.]*\).*/\1/' | sort -n |
  awk '{ all[NR] = $1 } END { if (NR) printf "%.1f ms", all[int((NR + 1) / 2)]; else printf "-" }')
complete=$(field complete "$r")
echo
awk -v input="$input${repeat:+ x $repeat}" -v tolerance="$tolerance" -v frames="$frames_in" \
  -v out="$frames_out" -v complete="$complete" -v partial="$(field partial "$r")" \
  -v points="$(field points "$r")" -v wire="$(field wire_bytes "$r")" -v encode="$encode" \
  -v p50="$(field latency_p50_ms "$r")" -v p99="$(field latency_p99_ms "$r")" \
  -v error="$(field max_error_mm "$r")" -v ratio="$(field max_error_ratio "$r")" \
  -v checked="$(field checked "$r")" -v dropped="$(field dropped "$r")" '
  function row(name, text) { printf "  %-10s %s\n", name, text }
  BEGIN {
    raw = 12 * points
    row("input", sprintf("%s, tolerance %s", input, tolerance))
    row("frames", sprintf("%d given, %d dropped, %d sent, %d received whole, %d incomplete, %d lost",
        frames, frames - out, out, complete, partial, out - complete - partial))
    allowed = dropped > 0 ? sprintf(" (%d dropped, as the options say)", dropped) : ""
    row("points", sprintf("%d received%s", points, allowed))
    row("raw", sprintf("%.2f MB, 12 bytes a point", raw / 1e6))
    row("packed", sprintf("%.2f MB received, key packets and envelopes included", wire / 1e6))
    if (points > 0 && wire > 0)
      row("ratio", sprintf("%.1f : 1, %.3f bits a point", raw / wire, 8 * wire / points))
    row("encode", sprintf("p50 %s from memory to packed", encode))
    row("latency", sprintf("p50 %s ms, p99 %s ms from memory to readable cloud", p50, p99))
    row("max error", sprintf("%s mm, %s of its bound, over %d frames checked", error, ratio, checked))
  }'
for file in "$cloud" "$picture"; do
  [ -s "$file" ] && printf '  %-10s %s\n' wrote "$file"
done

[ "$interrupted" = no ] || exit 130
[ "$receiver_code" -ne 5 ] || die "a point is further off than its bound" 5
if [ "$receiver_code" -ne 0 ] || [ "$complete" -ne "$frames_in" ] || [ "$frames_in" -eq 0 ]; then
  sed -n 's/^planecast-recv: /  /p' "$temporary/receiver.log" >&2
  [ "$frames_out" -eq "$frames_in" ] ||
    echo "  planecastd dropped $((frames_in - frames_out)) frames: this computer is too slow, or too" \
      "busy, for the rate; try a lower --rate, or --wait" >&2
  [ "$(field skipped "$r")" = 0 ] ||
    echo "  planecast-recv was too slow, or held up, for $(field skipped "$r") frames" >&2
  # A busy computer is no fault of the stream: show it once more at a rate that leaves room.
  if [ "${PLANECAST_DEMO_AGAIN:-}" = "" ] && [ "$frames_in" -gt 0 ] &&
    [ -z "$(given rate)" ]; then
    echo "demo.sh: this computer is too busy for the input's own rate; once more at 10 Hz"
    clean
    trap - EXIT
    PLANECAST_DEMO_AGAIN=1 exec "$root/apps/demo.sh" "${arguments[@]}" --no-setup --no-build --rate 10
  fi
  die "not every frame arrived whole and within its bound"
fi
echo "  every frame arrived whole, every point within its bound"
