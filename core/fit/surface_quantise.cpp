#include "core/fit/surface_quantise.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace planecast {
namespace {

bool quantise_coefficient(double value, int shift, std::int32_t& out) noexcept {
  const double step = std::ldexp(1.0, shift);
  const double rounded = std::nearbyint(value / step) * step;
  if (!(std::abs(rounded) <= kMaxSurfaceCoefficient)) return false;
  out = static_cast<std::int32_t>(rounded);
  return true;
}

}  // namespace

double largest_ray_sum(const RayTable& rays, bool curved) noexcept {
  double most = 0;
  const auto look = [&](std::uint32_t u, std::uint32_t v) {
    const double x = std::abs(rays.x(u, v)) * 0x1p-27, y = std::abs(rays.y(u, v)) * 0x1p-27;
    most = std::max(most, x + y + (curved ? x * x + x * y + y * y : 0));
  };
  if (rays.width == 0 || rays.height == 0) return 1;
  for (std::uint32_t u = 0; u < rays.width; ++u) {
    look(u, 0);
    look(u, rays.height - 1U);
  }
  for (std::uint32_t v = 0; v < rays.height; ++v) {
    look(0, v);
    look(rays.width - 1U, v);
  }
  return most + 1;
}

int choose_shift(std::span<const RegionFit> fits, double ray_sum) noexcept {
  double sigma = 0;
  for (const RegionFit& fit : fits) {
    if (fit.valid) sigma = sigma == 0 ? fit.min_sigma : std::min(sigma, fit.min_sigma);
  }
  if (sigma == 0) return 0;
  int shift = 0;
  while (shift < kMaxSurfaceShift &&
         std::ldexp(0.5, shift + 1) * ray_sum <= kRoundingShare * sigma) {
    ++shift;
  }
  return shift;
}

bool quantise_surface(const FloatSurface& s, int shift, Surface& out) noexcept {
  return quantise_coefficient(s.a, shift, out.a) && quantise_coefficient(s.b, shift, out.b) &&
         quantise_coefficient(s.c, shift, out.c) && quantise_coefficient(s.d, shift, out.d) &&
         quantise_coefficient(s.e, shift, out.e) && quantise_coefficient(s.f, shift, out.f);
}

}  // namespace planecast
