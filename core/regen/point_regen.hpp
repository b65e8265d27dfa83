// Points of a list from the grid to metres. Decoder half: IEEE double, cut to float once.
#pragma once

#include <span>

#include "core/base/status.hpp"
#include "core/model/point_grid.hpp"

namespace planecast {

/// Writes points[i] in metres to out[i] (docs/wire-format.md, "Points to metres"). kWrongSize:
/// sizes disagree; kBadSymbol: bits of a float that is not finite. O(n), no allocation.
Status regenerate_points(const PointStream& stream, std::span<const GridPoint> points,
                         std::span<Point3f> out) noexcept;

}  // namespace planecast
