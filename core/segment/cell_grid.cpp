#include "core/segment/cell_grid.hpp"

#include <algorithm>

#include "core/base/lanes.hpp"
#include "core/model/surface.hpp"

namespace planecast {
namespace {

constexpr std::uint32_t kSide = 8;
constexpr float kIvOne = 2147483648.0F;  // 2^kInverseDepthBits
constexpr double kRayOne = 1.0 / (1 << 27);
constexpr double kUnknownNoise = 0.002;  // [1/m]
constexpr double kSeedShare = 0.6;       // of a cell's pixels, for a plane of its own
constexpr double kJoinShare = 0.5;

// Depth and rays of one cell, gathered so that cells cut by the image border look like others.
struct CellPixels {
  std::uint16_t depth[64] = {};
  std::int32_t x[64] = {};
  std::int32_t y[64] = {};
};

void gather(const RayTable& rays, const std::uint16_t* depth, std::uint32_t u0, std::uint32_t v0,
            CellPixels& out) noexcept {
  const std::uint32_t wide = std::min(kSide, rays.width - u0);
  const std::uint32_t high = std::min(kSide, rays.height - v0);
  if (wide < kSide || high < kSide) out = {};
  for (std::uint32_t v = 0; v < high; ++v) {
    for (std::uint32_t u = 0; u < wide; ++u) {
      const std::uint32_t i = v * kSide + u;
      out.depth[i] = depth[std::size_t{v0 + v} * rays.width + u0 + u];
      out.x[i] = rays.x(u0 + u, v0 + v);
      out.y[i] = rays.y(u0 + u, v0 + v);
    }
  }
}

void gather_whole(const RayTable& rays, const std::uint16_t* depth, std::uint32_t u0,
                  std::uint32_t v0, CellPixels& out) noexcept {
  for (std::uint32_t v = 0; v < kSide; ++v) {
    std::memcpy(out.depth + v * kSide, depth + std::size_t{v0 + v} * rays.width + u0,
                kSide * sizeof(std::uint16_t));
    if (rays.separable) {
      std::memcpy(out.x + v * kSide, &rays.x_q27[u0], kSide * sizeof(std::int32_t));
      std::fill_n(out.y + v * kSide, kSide, rays.y_q27[v0 + v]);
    } else {
      const std::size_t at = std::size_t{v0 + v} * rays.width + u0;
      std::memcpy(out.x + v * kSide, &rays.x_q27[at], kSide * sizeof(std::int32_t));
      std::memcpy(out.y + v * kSide, &rays.y_q27[at], kSide * sizeof(std::int32_t));
    }
  }
}

// Sums about (x0, y0, w0), a point of the cell: floats are exact enough so near.
PlaneSums local_sums(const CellPixels& pixels, std::int32_t x0, std::int32_t y0, float& w0) {
  Float4 w[16];
  Float4 count = all4(0), total = all4(0);
  const Float4 one = all4(1);
  for (int i = 0; i < 16; ++i) {
    const Float4 depth = load4(pixels.depth + 4 * i);
    const Int4 reading = depth > all4(0);
    w[i] = keep4(reading, all4(kIvOne) / max4(depth, one));
    count += keep4(reading, one);
    total += w[i];
  }
  PlaneSums out;
  out.n = sum4(count);
  if (out.n == 0) return out;
  w0 = sum4(total) / static_cast<float>(out.n);
  const Int4 x_origin = {x0, x0, x0, x0}, y_origin = {y0, y0, y0, y0};
  const Float4 scale = all4(static_cast<float>(kRayOne)), middle = all4(w0);
  Float4 sx = all4(0), sy = sx, sxx = sx, sxy = sx, syy = sx, sw = sx, sxw = sx, syw = sx, sww = sx;
  for (int i = 0; i < 16; ++i) {
    const Int4 reading = w[i] > all4(0);
    const Float4 x = keep4(reading, to_float4(load4(pixels.x + 4 * i) - x_origin) * scale);
    const Float4 y = keep4(reading, to_float4(load4(pixels.y + 4 * i) - y_origin) * scale);
    const Float4 d = keep4(reading, w[i] - middle);
    sx += x;
    sy += y;
    sxx += x * x;
    sxy += x * y;
    syy += y * y;
    sw += d;
    sxw += x * d;
    syw += y * d;
    sww += d * d;
  }
  out.x = sum4(sx);
  out.y = sum4(sy);
  out.xx = sum4(sxx);
  out.xy = sum4(sxy);
  out.yy = sum4(syy);
  out.w = sum4(sw);
  out.xw = sum4(sxw);
  out.yw = sum4(syw);
  out.ww = sum4(sww);
  return out;
}

}  // namespace

InverseNoise::InverseNoise(const StreamConfig& config) noexcept {
  const double unit_m = static_cast<double>(config.camera.unit_pm) * 1e-12;
  uniform_ = kIvOne * unit_m * kUnknownNoise;
  if (config.lattice.present()) {
    // Levels are finer than sigma where both are known, and what predictions are judged by.
    uniform_ = kIvOne * 256.0 / config.lattice.c_q8;
    // Unless sigma decides which points stay.
    if (config.tolerance == ToleranceKind::kSurfaces &&
        config.noise.kind == NoiseModel::Kind::kStereo) {
      uniform_ = std::max(uniform_, kIvOne * unit_m * config.noise.s());
    }
  } else if (config.noise.kind == NoiseModel::Kind::kStereo && config.noise.s_e9 > 0) {
    uniform_ = kIvOne * unit_m * config.noise.s();
  } else if (config.noise.kind == NoiseModel::Kind::kTof && config.noise.s_e9 > 0) {
    uniform_ = 0;
    quadratic_ = config.noise.s() / (unit_m * kIvOne);
  }
}

void CellGrid::layout(Arena& arena, std::uint32_t max_width, std::uint32_t max_height) noexcept {
  cells_ = arena.take<Cell>(std::size_t{(max_width + 7) / 8} * ((max_height + 7) / 8));
}

Status CellGrid::process(const StreamConfig& config, const RayTable& rays,
                         std::span<const std::uint16_t> depth) noexcept {
  if (depth.size() != std::size_t{rays.width} * rays.height) return Status::kWrongSize;
  wide_ = (rays.width + 7U) / 8U;
  high_ = (rays.height + 7U) / 8U;
  if (std::size_t{wide_} * high_ > cells_.size()) {
    wide_ = high_ = 0;
    return Status::kFrameTooLarge;
  }
  const InverseNoise noise(config);
  CellPixels pixels;
  for (std::uint32_t cy = 0; cy < high_; ++cy) {
    for (std::uint32_t cx = 0; cx < wide_; ++cx) {
      const std::uint32_t u0 = cx * kSide, v0 = cy * kSide;
      const bool whole = u0 + kSide <= rays.width && v0 + kSide <= rays.height;
      if (whole) {
        gather_whole(rays, depth.data(), u0, v0, pixels);
      } else {
        gather(rays, depth.data(), u0, v0, pixels);
      }
      Cell& cell = cells_[std::size_t{cy} * wide_ + cx];
      cell = {};
      const std::uint32_t area =
          whole ? 64U : std::min(kSide, rays.width - u0) * std::min(kSide, rays.height - v0);
      const std::uint32_t middle = whole ? 36U : 0U;
      float w0 = 0;
      const PlaneSums local = local_sums(pixels, pixels.x[middle], pixels.y[middle], w0);
      if (local.n == 0) continue;
      const double sigma = noise.sigma(w0);
      cell.variance = static_cast<float>(sigma * sigma);
      cell.usable = local.n >= kJoinShare * area && local.n >= 4;
      FloatPlane plane;
      if (local.n >= kSeedShare * area && local.n >= 4 && local.solve(plane)) {
        cell.flat = true;
        cell.own_residual = static_cast<float>(local.mean_square(plane) / cell.variance);
      }
      cell.sums = local.moved(pixels.x[middle] * kRayOne, pixels.y[middle] * kRayOne, w0);
    }
  }
  return Status::kOk;
}

}  // namespace planecast
