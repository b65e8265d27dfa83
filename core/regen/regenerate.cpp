#include "core/regen/regenerate.hpp"

#include <bit>
#include <cstring>

#include "core/sensor/z_grid.hpp"

namespace planecast {
namespace {

constexpr std::uint32_t kBands = 8;
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

using Double4 = double __attribute__((vector_size(32)));

// Four points of a row in optical axes, each coordinate cut to float once. A ray's unit is a power
// of two: whichever factor takes it, the product is the same.
void regenerate_four(const DepthScale& scale, const std::uint16_t* depth, Int4 x_ray, Int4 y_ray,
                     Point3f* out) noexcept {
  const Float4 z = scale.z4(depth);
  const Double4 unit = {kRayUnit, kRayUnit, kRayUnit, kRayUnit};
  const Double4 along = __builtin_convertvector(z, Double4) * unit;
  Float4 x = __builtin_convertvector(__builtin_convertvector(x_ray, Double4) * along, Float4);
  Float4 y = __builtin_convertvector(__builtin_convertvector(y_ray, Double4) * along, Float4);
  Count4 counts;
  std::memcpy(&counts, depth, sizeof counts);
  const Int4 there = __builtin_convertvector(counts, Int4) != 0;
  x = there ? x : all4(kHole);  // written out: which NaN arithmetic gives differs between machines
  y = there ? y : all4(kHole);
  const Float4 first = __builtin_shufflevector(x, y, 0, 4, 1, 5);  // x0 y0 x1 y1
  const Float4 last = __builtin_shufflevector(x, y, 2, 6, 3, 7);
  const Float4 z0_x1 = __builtin_shufflevector(z, first, 0, 6, 0, 6);
  const Float4 y1_z1 = __builtin_shufflevector(first, z, 3, 5, 3, 5);
  auto* const to = reinterpret_cast<float*>(out);
  store4(to, __builtin_shufflevector(first, z0_x1, 0, 1, 4, 5));
  store4(to + 4, __builtin_shufflevector(y1_z1, last, 0, 1, 4, 5));
  store4(to + 8, __builtin_shufflevector(z, last, 2, 6, 7, 3));
}

void regenerate_rows(const Bands& all, std::uint32_t v0, std::uint32_t v1) noexcept {
  const auto& [rays, scale, depth, out, optical, axes] = all;
  std::size_t i = std::size_t{v0} * rays.width;
  for (std::uint32_t v = v0; v < v1; ++v) {
    std::uint32_t u = 0;
    if (optical) {
      const std::size_t row = std::size_t{v} * rays.width;
      const std::int32_t* const x = rays.x_q27.data() + (rays.separable ? 0 : row);
      const std::int32_t* const y = rays.y_q27.data() + (rays.separable ? v : row);
      const Int4 same = Int4{*y, *y, *y, *y};
      for (; u + 4 <= rays.width; u += 4, i += 4) {
        regenerate_four(scale, &depth[i], load4(x + u), rays.separable ? same : load4(y + u),
                        &out[i]);
      }
    }
    for (; u < rays.width; ++u, ++i) {
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
