// Planes that are known badly take the direction of ones known well, where their readings allow it:
// what people build is mostly parallel and at right angles.
#pragma once

#include <span>

#include "core/fit/plane_fit.hpp"

namespace planecast {

/// Turns planes of `regions`, fitted in `fits` (fits[k - 1] of region k), by no more than noise may
/// have turned them: parallel to a better known plane, or to the common perpendicular of two, else
/// at right angles to one. Returns how many were turned. O(cells + regions^3); no allocation.
int align_planes(const RegionMap& regions, std::span<RegionFit> fits) noexcept;

}  // namespace planecast
