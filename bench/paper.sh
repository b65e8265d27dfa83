#!/usr/bin/env bash
# The paper's whole evaluation on the data at hand; writes docs/paper-results.md and its plots.
#   bench/paper.sh BUILD [ROWS.json]     BUILD: of the preset bench; rows are kept in ROWS.json, and
#                                        clouds that it has rows of are not run again
# sim:room always; recordings where $PLANECAST_DATA has them, five a class where there are five.
# About ten minutes. Classes as the paper names them, by how much of a cloud is flat.
set -euo pipefail
export LC_ALL=C

if [ $# -lt 1 ]; then
  sed -n '2,6s/^# \{0,1\}//p' "$0"
  exit 2
fi
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
build=$1
rows=${2:-$(mktemp)}
data=${PLANECAST_DATA:-$here/../../shared/data}
: >>"$rows"

# cloud CLASS NAME INPUT [options]: appends its rows; one that is not there is named on stderr.
cloud() {
  local class=$1 name=$2 input=$3
  shift 3
  if [[ "$input" != sim:* ]]; then
    input=$data/$input
    if [ ! -e "$input" ]; then
      echo "skipped: $name; no $input" >&2
      return
    fi
  fi
  if grep -q "\"cloud\":\"$name\"" "$rows"; then
    return
  fi
  echo "$class $name" >&2
  "$build/bench/paper" "$class" "$name" "$input" "$@" >"$rows.part"
  cat "$rows.part" >>"$rows"  # whole clouds only
  rm "$rows.part"
}

kinect=depth_frames/pcl_misc
list=unorganised
cloud simulated sim_room sim:room --sweep --compare
cloud high stairs depth_frames/stair_kinect2/0000_depth.png \
  --camera 365.31,365.31,254.68,208.55,0.001 --pcl --sweep --compare
cloud high region_growing_rgb $kinect/region_growing_rgb_tutorial.pcd --pcl
cloud high clorox $kinect/milk_cartoon_all_small_clorox.pcd --pcl
cloud high room_scan1 $list/pcl/room_scan1.pcd
cloud high region_growing $list/pcl/region_growing_tutorial.pcd --units 0.001 --compare
cloud medium mug $kinect/table_scene_mug_stereo_textured.pcd --pcl --compare
cloud medium desk depth_frames/pcl_grabber_kinect1/frame_20121214T142255.814212.pcd --pcl
cloud medium desk_later depth_frames/pcl_grabber_kinect1/frame_20121214T142256.332395.pcd --pcl
cloud medium office1 $kinect/office1.pcd --pcl
cloud medium street lidar_seq/kitti_hdl64_drive_0048/0000000000.pcd
cloud low people $kinect/five_people.pcd --pcl --compare
cloud low capture1 depth_frames/pcl_pairwise_kinect1/capture0001.pcd --pcl
cloud low capture2 depth_frames/pcl_pairwise_kinect1/capture0002.pcd --pcl
cloud low capture3 depth_frames/pcl_pairwise_kinect1/capture0003.pcd --pcl
cloud low capture4 depth_frames/pcl_pairwise_kinect1/capture0004.pcd --pcl
cloud complex tree $list/itsme_trees/tree_2_pc.txt
cloud complex buttressed_tree $list/itsme_trees/buttressed_tree_1_pc.txt --compare
cloud complex tree_uav $list/itsme_trees/pc_tree_uav.txt

python3 -B "$here/paper_report.py" "$rows" "$here/.."
