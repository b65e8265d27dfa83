// Rounds fitted planes to the integers of the wire: coefficients in multiples of 2^shift, with the
// coarsest shift that the noise of the readings hides.
#pragma once

#include <cstdint>
#include <span>

#include "core/fit/plane_fit.hpp"
#include "core/model/surface.hpp"
#include "core/sensor/ray_table.hpp"

namespace planecast {

/// Share of a sigma (or level) that rounding may move a surface by, anywhere in the frame.
inline constexpr double kRoundingShare = 0.15;

/// Largest shift the wire can say.
inline constexpr int kMaxSurfaceShift = 31;

/// Largest |x| + |y| + 1 of any ray at the border of the image, with x^2 + |x y| + y^2 for degree
/// two: what rounding errors of half a step in each coefficient add up to, in half steps.
double largest_ray_sum(const RayTable& rays, bool curved) noexcept;

/// Coarsest shift whose rounding error stays within kRoundingShare * sigma for every valid fit;
/// 0 when there is none. `ray_sum`: largest_ray_sum().
int choose_shift(std::span<const RegionFit> fits, double ray_sum) noexcept;

/// The surface in multiples of 2^shift; false when a coefficient leaves +-kMaxSurfaceCoefficient.
bool quantise_surface(const FloatSurface& surface, int shift, Surface& out) noexcept;

}  // namespace planecast
