// A surface within one block: affine in levels, from three exact evaluations at the block's
// middle. Eight pixels are too few for the curvature of 1/z to matter to a prediction.
#pragma once

#include <algorithm>
#include <cstdint>

#include "core/model/surface.hpp"
#include "core/predict/bound_table.hpp"
#include "core/predict/level_table.hpp"
#include "core/sensor/ray_table.hpp"

namespace planecast {

/// level_q8(u, v) = at_origin + dx (u - u0) + dy (v - v0), in 1/256 level, (u0, v0) the block's
/// first pixel.
struct BlockSurface {
  std::int32_t at_origin = 0;
  std::int32_t dx = 0;
  std::int32_t dy = 0;

  /// At pixel (x, y) of the block, 0..7.
  std::int32_t at(std::uint32_t x, std::uint32_t y) const noexcept {
    return at_origin + dx * static_cast<std::int32_t>(x) + dy * static_cast<std::int32_t>(y);
  }
};

/// Evaluates `surface` for the block (bx, by). Cost: five ray look-ups and divisions.
inline BlockSurface block_surface(const Surface& surface, const RayTable& rays,
                                  const LevelTable& levels, std::uint32_t bx,
                                  std::uint32_t by) noexcept {
  const std::uint32_t u0 = bx * kBlockSide;
  const std::uint32_t v0 = by * kBlockSide;
  const std::uint32_t last_u = rays.width - 1U;
  const std::uint32_t last_v = rays.height - 1U;
  const auto level_at = [&](std::uint32_t u, std::uint32_t v) {
    return levels.level_q8(surface.inverse_depth(rays.x(u, v), rays.y(u, v)));
  };
  const std::uint32_t u1 = std::min(u0 + 7U, last_u);
  const std::uint32_t v1 = std::min(v0 + 7U, last_v);
  const std::uint32_t um = (u0 + u1) / 2;
  const std::uint32_t vm = (v0 + v1) / 2;
  const std::int32_t middle = level_at(um, vm);
  BlockSurface out;
  const auto wide = static_cast<std::int32_t>(u1 - u0);
  const auto high = static_cast<std::int32_t>(v1 - v0);
  out.dx = wide > 0 ? (level_at(u1, vm) - level_at(u0, vm)) / wide : 0;
  out.dy = high > 0 ? (level_at(um, v1) - level_at(um, v0)) / high : 0;
  out.at_origin = middle - out.dx * static_cast<std::int32_t>(um - u0) -
                  out.dy * static_cast<std::int32_t>(vm - v0);
  return out;
}

/// The exact depth count of a surface at a pixel: where its ray meets it, rounded; 0 when it does
/// not (behind the camera, or beyond 65535 counts).
inline std::uint16_t surface_depth(const Surface& surface, std::int32_t x_q27,
                                   std::int32_t y_q27) noexcept {
  const std::int64_t iv = surface.inverse_depth(x_q27, y_q27);
  if (iv < 32768) return 0;
  const std::uint64_t depth =
      ((std::uint64_t{1} << 32U) / static_cast<std::uint64_t>(iv) + 1) >> 1U;
  return depth > 65535 ? std::uint16_t{0} : static_cast<std::uint16_t>(depth);
}

}  // namespace planecast
