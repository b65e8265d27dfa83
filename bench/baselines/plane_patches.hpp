// Planar patches of a cloud for the baselines that code planes (Morell 2014, DT2016, GMM2018):
// normals of local windows, grown into patches (after Viejo and Cazorla). Not the product's own
// segmentation, on purpose.
#pragma once

#include <Eigen/Core>

#include "bench/baselines/baseline.hpp"

namespace planecast::baselines {

/// Points that lie on one plane.
struct PlanePatch {
  Eigen::Vector3d origin;   ///< mean of the members [m]
  Eigen::Vector3d u, v, n;  ///< right-handed unit axes, n the normal
  std::vector<std::uint32_t> members;
};

struct PlanePatches {
  std::vector<PlanePatch> patches;  ///< the largest first
  std::vector<std::uint32_t> rest;  ///< points on none
};

/// Grows patches of at least 50 points: a neighbour joins whose normal is within 15 degrees of the
/// patch's and which lies within 3 median point spacings of its plane. O(n log n).
PlanePatches find_patches(const PointList& points);

}  // namespace planecast::baselines
