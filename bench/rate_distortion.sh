#!/usr/bin/env bash
# Every frame of the rate-distortion benchmark through our codec and every packaged peer, each frame
# in one run; then the tables of docs/benchmarks.md and the curves of docs/plots.
#   bench/rate_distortion.sh BUILD CSV [FRAME...]     BUILD: of the preset bench; CSV: where rows go
# sim:room always; recordings where $PLANECAST_DATA has them. About two minutes a frame. With FRAMEs
# only these run, and their rows replace the old ones. EFFORTS=fast,best in the environment.
set -euo pipefail
export LC_ALL=C

if [ $# -lt 2 ]; then
  sed -n '2,7s/^# \{0,1\}//p' "$0"
  exit 2
fi
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
build=$1
csv=$2
shift 2
wanted=" $* "
data=${PLANECAST_DATA:-$here/../../shared/data}
rows=$(mktemp)
trap 'rm -f "$rows"' EXIT

# frame NAME INPUT [options]: runs it when it is wanted and there.
frame() {
  local name=$1 input=$2
  shift 2
  if [ "$wanted" != "  " ] && [[ "$wanted" != *" $name "* ]]; then return; fi
  if [[ "$input" != sim:* ]]; then
    input=$data/$input
    if [ ! -e "$input" ]; then
      echo "skipped: $name; no $input" >&2
      return
    fi
  fi
  echo "$name" >&2
  "$build/bench/rate_distortion" "$name" "$input" --header --efforts "${EFFORTS:-fast}" "$@" >"$rows"
  if [ -s "$csv" ]; then
    grep -v "^$name," "$csv" >"$csv.new" || true
    tail -n +2 "$rows" >>"$csv.new"
    mv "$csv.new" "$csv"
  else
    cp "$rows" "$csv"
  fi
}

kinect=depth_frames/pcl_misc
frame sim_room sim:room --targets 5.5,10.3,18.2
frame realsense depth_seq/aims_realsense/0.png --camera 383.8,383.8,321.7,236.8,0.001 \
  --range 0.2,10 --noise stereo:0.003 --targets 5.5,10.3,18.2
frame kinect_office $kinect/office1.pcd --targets 5.5,10.3
frame kinect_capture depth_frames/pcl_pairwise_kinect1/capture0001.pcd --targets 5.5,10.3
frame kinect_region_growing $kinect/region_growing_rgb_tutorial.pcd --targets 5.5,10.3
frame kinect2_stairs depth_frames/stair_kinect2/0000_depth.png \
  --camera 365.31,365.31,254.68,208.55,0.001 --noise tof:0.005 --targets 5.3
frame azure_room depth_frames/azure_kinect_zdepth/room0_320x288_u16le.raw --size 320x288 \
  --camera 252,252,160,144,0.001 --noise tof:0.005 --targets 6.2

python3 -B "$here/rate_distortion_report.py" "$csv" "$here/.."
