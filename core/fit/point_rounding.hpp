// Points of a list from metres to the stream's grid, the one place where they are rounded: what
// cannot come back within the bound is refused here, before anything is packed. Encoder half.
#pragma once

#include <cstdint>
#include <span>

#include "core/base/status.hpp"
#include "core/model/point_grid.hpp"

namespace planecast {

/// Bound of coded points in steps, for points whose coordinates are at most `reach_m` in size: what
/// is left of the bound when the grid's rounding, the output's float32 and a little for double are
/// off. Negative: nothing is left.
double tolerance_steps(double bound_m, double step_m, double reach_m) noexcept;

/// Rounds those of `points` [m] that have fates[i] == 0 to the grid, in their order, into the first
/// `count` of `out`. kWrongSize: sizes disagree or `out` is too small; kBoundExceeded: a point that
/// is not finite, lies beyond the grid, does not come back exactly (tolerance_steps 0 and lossless)
/// or not within the bound, because float32 is too coarse so far from zero. O(n), no allocation.
Status round_points(const StreamConfig& config, std::span<const Point3f> points,
                    std::span<const std::uint8_t> fates, std::span<GridPoint> out,
                    std::uint32_t& count) noexcept;

}  // namespace planecast
