// What the stages of a stream are told beside its key packet: it changes what is sent, and no
// decoder need know it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>

#include "core/base/work_team.hpp"

namespace planecast {

class FrameBudget;

/// What stages need to know beside the stream's tables.
struct StageOptions {
  std::size_t slice_bytes = 1190;  ///< most bytes of a slice, header included
  std::uint16_t range_min = 0;     ///< [counts] readings outside become holes
  std::uint16_t range_max = 65535;
  bool drop_outliers = false;
  bool surfaces = true;           ///< false: neighbour prediction only
  bool curved = true;             ///< surfaces of degree two where they pay
  FrameBudget* budget = nullptr;  ///< shared by the stages of one encoder; none = no limit
  WorkTeam team{};                ///< packs depth frames with more than one thread
  // Lists of points:
  double range_min_m = 0;  ///< distance from the zero of the input; points outside are taken out
  double range_max_m = std::numeric_limits<double>::infinity();
  bool paper = false;             ///< surfaces by the paper's chain, else over voxels
  std::uint32_t neighbours = 30;  ///< of each point, for outliers, normals and regions
  double outlier_deviations = 3;  ///< over the mean distance to the neighbours
  double smoothness_deg = 3;      ///< most angle between the normals of a region's neighbours
  std::uint64_t seed = 1;         ///< of sample consensus
};

}  // namespace planecast
