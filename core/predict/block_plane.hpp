// A block whose levels are one plane, coded as its distance from a plane foretold by the blocks
// around and by the surface: no pixel of it waits for another (docs/wire-format.md, "Flat blocks").
// Both halves share this arithmetic. Integers, 1/256 level.
#pragma once

#include <algorithm>
#include <cstdint>

#include "core/predict/block_surface.hpp"

namespace planecast {

/// A plane over the 8 x 8 pixels of a block, around the block's middle at (3.5, 3.5).
struct BlockPlane {
  std::int32_t middle = 0;  ///< 256 .. 256 last level
  std::int32_t dx = 0, dy = 0;

  /// Steepest slope kept; keeps sums of slopes far from 2^31.
  static constexpr std::int32_t kMaxSlope = std::int32_t{1} << 18;

  static BlockPlane clamped(std::int32_t middle, std::int32_t dx, std::int32_t dy,
                            std::int32_t last_level) noexcept {
    return {std::clamp(middle, 256, last_level * 256), std::clamp(dx, -kMaxSlope, kMaxSlope),
            std::clamp(dy, -kMaxSlope, kMaxSlope)};
  }
  /// The same, as a surface at the block's pixels.
  BlockSurface surface() const noexcept { return {middle - ((7 * (dx + dy)) >> 1), dx, dy}; }
  /// The plane `x` blocks right and `y` blocks below, at its middle.
  std::int32_t beyond(std::int32_t x, std::int32_t y) const noexcept {
    return middle + 8 * (x * dx + y * dy);
  }
};

/// What foretells the plane of a block. Null: that block is not flat or outside the tile.
struct PlaneHints {
  const BlockPlane* left = nullptr;
  const BlockPlane* above = nullptr;
  const BlockPlane* above_left = nullptr;
  const BlockPlane* above_right = nullptr;
  const BlockSurface* surface = nullptr;  ///< the surface that the block lies on, or null
  std::int32_t row_above =
      0;  ///< mean level of the eight pixels above, times 256; 0: not all there
  std::int32_t fallback = 256;  ///< middle of the flat block coded last
};

/// Steps of a plane's offset and slopes by the half-width of the bound, in 1/256 level: the window
/// of 2 half + 1 levels is 4 offsets wide, and a slope's step moves a corner by about as much.
struct PlaneSteps {
  std::int32_t offset, slope;
  explicit PlaneSteps(std::int32_t half_width) noexcept
      : offset((2 * half_width + 1) * 64), slope((2 * half_width + 1) * 16) {}
};

/// The plane that the hints foretell. `half_widths` of the block's ray class.
inline BlockPlane foretell_plane(const PlaneHints& h, const std::uint8_t* half_widths,
                                 std::int32_t last_level) noexcept {
  if (h.surface != nullptr) {
    const BlockPlane s =
        BlockPlane::clamped(h.surface->at_origin + ((7 * (h.surface->dx + h.surface->dy)) >> 1),
                            h.surface->dx, h.surface->dy, last_level);
    const std::int32_t reach = half_widths[std::clamp((s.middle + 128) >> 8, 1, last_level)];
    const std::int32_t limit = 256 * (12 + 3 * reach);
    std::int32_t sum = 0, weight = 0;
    const auto draw = [&](std::int32_t off, std::int32_t w) {
      if (off > limit || off < -limit) return;
      sum += w * off;
      weight += w;
    };
    if (h.left != nullptr) draw(h.left->middle - s.beyond(-1, 0), 2);
    if (h.above != nullptr) draw(h.above->middle - s.beyond(0, -1), 2);
    if (h.above_left != nullptr) draw(h.above_left->middle - s.beyond(-1, -1), 1);
    if (h.above_right != nullptr) draw(h.above_right->middle - s.beyond(1, -1), 1);
    if (h.above == nullptr && h.row_above != 0)
      draw(h.row_above - (s.middle - ((9 * s.dy) >> 1)), 2);
    const std::int32_t drift = weight != 0 ? sum / weight : 0;
    return BlockPlane::clamped(s.middle + drift, s.dx, s.dy, last_level);
  }
  if (h.left != nullptr && h.above != nullptr) {
    return BlockPlane::clamped((h.left->beyond(1, 0) + h.above->beyond(0, 1)) >> 1,
                               (h.left->dx + h.above->dx) >> 1, (h.left->dy + h.above->dy) >> 1,
                               last_level);
  }
  const auto from = [&](const BlockPlane& p, std::int32_t x, std::int32_t y) {
    return BlockPlane::clamped(p.beyond(x, y), p.dx, p.dy, last_level);
  };
  if (h.left != nullptr) return from(*h.left, 1, 0);
  if (h.above != nullptr) return from(*h.above, 0, 1);
  if (h.row_above != 0) return BlockPlane::clamped(h.row_above, 0, 0, last_level);
  if (h.above_left != nullptr) return from(*h.above_left, 1, 1);
  if (h.above_right != nullptr) return from(*h.above_right, -1, 1);
  return BlockPlane::clamped(h.fallback, 0, 0, last_level);
}

/// How much foretells a plane: 0 nothing flat beside or above, 1 one, 2 both; 3 more on a surface.
inline int plane_context(const PlaneHints& h) noexcept {
  return (h.left != nullptr ? 1 : 0) + (h.above != nullptr ? 1 : 0) +
         (h.surface != nullptr ? 3 : 0);
}

}  // namespace planecast
