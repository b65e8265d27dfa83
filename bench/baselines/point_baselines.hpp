// The point-cloud codecs that the benchmarks compare with, each in the file of its name.
#pragma once

#include "bench/baselines/baseline.hpp"
#include "bench/baselines/byte_coders.hpp"

namespace planecast::baselines {

/// Draco (draco_points.cpp). `quantisation_bits` of the bounding box's longest side; `level` 0..10
/// as its tool's -cl. kd-tree: order lost; else sequential: order kept.
std::unique_ptr<PointBaseline> draco_points(bool kd_tree, int level, int quantisation_bits);
bool draco_available();

}  // namespace planecast::baselines
