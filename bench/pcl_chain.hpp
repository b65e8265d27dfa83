// The paper's chain by the Point Cloud Library itself, which the paper most likely used: what ours
// is held against. Only where libpcl is installed (toolchains/setup.sh --pcl).
#pragma once

#include "bench/paper_steps.hpp"

namespace planecast::bench {

/// True when this program was built with PCL.
bool pcl_available();

/// Outlier filter (50 neighbours, 1 deviation), normals (50), region growing (30 neighbours, 3
/// degrees, no curvature limit, 50 points), sample consensus (10 mm, again while a tenth is left),
/// ConcaveHull (alpha 0.1 m), random points inside: the parameters of PCL's tutorials. Fills what
/// ChainResult says of points, regions, planes, hull_points and clouds; encode_ms is of one run.
/// Throws std::runtime_error without PCL.
ChainResult run_pcl_chain(const baselines::PointList& points);

/// Corners of pcl::ConcaveHull's outlines round `points`, which lie on one plane.
std::size_t pcl_hull_corners(const baselines::PointList& points, double alpha_m);

}  // namespace planecast::bench
