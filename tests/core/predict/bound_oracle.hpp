// The error contract in double arithmetic, apart from the integer tables that must keep it.
#pragma once

#include <cmath>
#include <cstdint>

#include "core/model/stream_config.hpp"
#include "core/sensor/ray_table.hpp"

namespace planecast::test {

struct Point3d {
  double x = 0, y = 0, z = 0;
};

inline double distance(const Point3d& a, const Point3d& b) {
  return std::sqrt((a.x - b.x) * (a.x - b.x) + (a.y - b.y) * (a.y - b.y) +
                   (a.z - b.z) * (a.z - b.z));
}

inline double unit_m(const StreamConfig& c) {
  return static_cast<double>(c.camera.unit_pm) * 1e-12;
}

/// The bound of the contract for a reading of `depth` counts [m].
inline double bound_m(const StreamConfig& c, std::uint32_t depth) {
  if (c.tolerance == ToleranceKind::kLossless) return 0;
  if (c.tolerance == ToleranceKind::kMetres) return c.tolerance_100nm * 1e-7;
  return c.sigmas_q16 / 65536.0 * c.noise.sigma_m(depth * unit_m(c));
}

/// Where a count lies on its pixel's ray, without any rounding to speak of.
inline Point3d exact_point(const StreamConfig& c, const RayTable& rays, std::uint32_t u,
                           std::uint32_t v, std::uint32_t depth) {
  const double z = depth * unit_m(c);
  return {rays.x(u, v) * 0x1p-27 * z, rays.y(u, v) * 0x1p-27 * z, z};
}

/// The same with every coordinate cut to float32, as clouds are written.
inline Point3d float_point(const StreamConfig& c, const RayTable& rays, std::uint32_t u,
                           std::uint32_t v, std::uint32_t depth) {
  const double z = static_cast<float>(depth * unit_m(c));
  return {static_cast<float>(rays.x(u, v) * 0x1p-27 * z),
          static_cast<float>(rays.y(u, v) * 0x1p-27 * z), z};
}

}  // namespace planecast::test
