// Statistical outlier removal on unorganised clouds: a point whose neighbours are, on average, much
// farther away than is usual in the frame (the paper's first step).
#pragma once

#include <cstdint>
#include <span>

#include "core/base/status.hpp"

namespace planecast {

/// What the frame's distances are and where the cut lies.
struct StatisticalCut {
  double mean = 0;       ///< of the mean distances [m]
  double deviation = 0;  ///< their standard deviation (of the sample: n - 1) [m]
  double cut = 0;        ///< mean + deviations * deviation [m]
  std::uint32_t outliers = 0;
};

/// Sets flags[i] = 1 where mean_distance[i] (of point i to its k nearest, PointNeighbours) exceeds
/// the frame's mean by more than `deviations` (>= 0, finite) standard deviations, else 0. Fewer
/// than two points have no outliers. kWrongSize; kBadConfig: deviations. O(n), no allocation.
Status flag_statistical_outliers(std::span<const float> mean_distance, double deviations,
                                 std::span<std::uint8_t> flags, StatisticalCut& cut) noexcept;

}  // namespace planecast
