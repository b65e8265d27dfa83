#include "core/regen/regenerate.hpp"

#include <bit>

#include "core/sensor/z_grid.hpp"

namespace planecast {
namespace {

constexpr std::uint32_t kBands = 8;
constexpr double kRayUnit = 1.0 / 134217728.0;  // 2^-27
const float kHole = std::bit_cast<float>(std::uint32_t{0x7fc00000});

// p' = R p + t of the cloud's axes, as a matrix computed once a frame.
struct Axes {
  double m[3][3];
  double t[3];
  bool flip_y;
};

Axes axes_of(const StreamConfig& config) noexcept {
  constexpr double kQ30 = 1.0 / 1073741824.0;
  const double w = config.axes.q_q30[0] * kQ30, x = config.axes.q_q30[1] * kQ30;
  const double y = config.axes.q_q30[2] * kQ30, z = config.axes.q_q30[3] * kQ30;
  Axes out{{{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
            {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
            {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}},
           {},
           config.mirror_y};
  for (int i = 0; i < 3; ++i) out.t[i] = static_cast<double>(config.axes.t_um[i]) * 1e-6;
  return out;
}

Point3f turn(const Axes& a, double x, double y, double z) noexcept {
  if (a.flip_y) y = -y;
  return {static_cast<float>(a.m[0][0] * x + a.m[0][1] * y + a.m[0][2] * z + a.t[0]),
          static_cast<float>(a.m[1][0] * x + a.m[1][1] * y + a.m[1][2] * z + a.t[1]),
          static_cast<float>(a.m[2][0] * x + a.m[2][1] * y + a.m[2][2] * z + a.t[2])};
}

// What all bands of rows share.
struct Bands {
  const RayTable& rays;
  const DepthScale& scale;
  std::span<const std::uint16_t> depth;
  std::span<Point3f> out;
  bool optical;
  Axes axes;
};

void regenerate_rows(const Bands& all, std::uint32_t v0, std::uint32_t v1) noexcept {
  const auto& [rays, scale, depth, out, optical, axes] = all;
  std::size_t i = std::size_t{v0} * rays.width;
  for (std::uint32_t v = v0; v < v1; ++v) {
    for (std::uint32_t u = 0; u < rays.width; ++u, ++i) {
      if (depth[i] == 0) {  // written out: which NaN arithmetic gives differs between machines
        out[i] = {kHole, kHole, kHole};
        continue;
      }
      const float z_float = scale.z(depth[i]);
      const double z = z_float;
      const double x = rays.x(u, v) * kRayUnit * z;
      const double y = rays.y(u, v) * kRayUnit * z;
      out[i] = optical ? Point3f{static_cast<float>(x), static_cast<float>(y), z_float}
                       : turn(axes, x, y, z);
    }
  }
}

}  // namespace

void DepthScale::build(const StreamConfig& config) noexcept {
  const ZGrid grid{config.camera.unit_pm, static_cast<ZGrid::Rule>(config.z_rule)};
  z_[0] = kHole;
  for (std::uint32_t d = 1; d < 65536; ++d) z_[d] = grid_z(grid, static_cast<std::uint16_t>(d));
}

Status regenerate(const StreamConfig& config, const RayTable& rays, const DepthScale& scale,
                  std::span<const std::uint16_t> depth, std::span<Point3f> out,
                  const WorkTeam& team) noexcept {
  const std::size_t pixels = std::size_t{rays.width} * rays.height;
  if (depth.size() < pixels || out.size() < pixels) return Status::kWrongSize;
  Bands bands{rays,           scale, depth, out, config.axes == PoseFixed{} && !config.mirror_y,
              axes_of(config)};
  team.run(
      kBands,
      [](void* job, std::uint32_t band, std::uint32_t) noexcept {
        const auto& all = *static_cast<const Bands*>(job);
        regenerate_rows(all, all.rays.height * band / kBands,
                        all.rays.height * (band + 1) / kBands);
      },
      &bands);
  return Status::kOk;
}

}  // namespace planecast
