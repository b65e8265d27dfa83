// How far the points of a cloud stray from the surfaces they lie on: the noise of a sensor nobody
// named. Cold path: allocates.
#pragma once

#include <cstddef>
#include <span>

#include "core/cloud/sensor_frame.hpp"

namespace planecast {

/// Median, over at most `samples` points spread through the list, of the deviation [m] of the k
/// nearest points (the point included) from the plane through them; 0 for fewer than four points.
/// Points that are not finite are skipped. O(n log n).
double surface_roughness_m(std::span<const Point3f> points, std::size_t samples = 2000,
                           std::size_t k = 16);

}  // namespace planecast
