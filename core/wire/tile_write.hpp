// Composite symbols of a tile, written: numbers as trees, coefficients, rectangles
// (docs/wire-format.md, "Tile"). Encoder half.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstdlib>

#include "core/wire/flat_fit.hpp"
#include "core/wire/range_encoder.hpp"
#include "core/wire/tile_syntax.hpp"

namespace planecast {

inline void code_coefficient(RangeEncoder& coder, std::int32_t value, int shift) noexcept {
  const std::int32_t scaled = value >> shift;
  const auto magnitude = static_cast<std::uint32_t>(std::abs(scaled));
  const int length = static_cast<int>(std::bit_width(magnitude));
  coder.raw(static_cast<std::uint32_t>(length), 5);
  if (length == 0) return;
  coder.raw(scaled < 0 ? 1 : 0, 1);
  if (length > 16) coder.raw(magnitude >> 16U, length - 16);
  const int low = std::min(length, 16);
  coder.raw(magnitude & ((1U << low) - 1U), low);
}

inline void code_surface(RangeEncoder& coder, const Surface& surface, int shift) noexcept {
  coder.raw(surface.curved() ? 1 : 0, 1);
  code_coefficient(coder, surface.a, shift);
  code_coefficient(coder, surface.b, shift);
  code_coefficient(coder, surface.c, shift);
  if (!surface.curved()) return;
  code_coefficient(coder, surface.d, shift);
  code_coefficient(coder, surface.e, shift);
  code_coefficient(coder, surface.f, shift);
}

inline void code_tree(RangeEncoder& coder, BitModel* models, int bits,
                      std::uint32_t value) noexcept {
  std::uint32_t node = 1;
  for (int i = bits - 1; i >= 0; --i) {
    const bool bit = ((value >> i) & 1U) != 0;
    coder.bit(models[node], bit);
    node = node * 2 + (bit ? 1 : 0);
  }
}

[[gnu::always_inline]] inline void code_plane_steps(RangeEncoder& coder, TileModels& models,
                                                    int kind, int context,
                                                    std::int32_t steps) noexcept {
  BitModel* unary = models.plane_length[kind][context];
  const auto magnitude = static_cast<std::uint32_t>(std::abs(steps));
  const int length = static_cast<int>(std::bit_width(magnitude));
  for (int i = 0; i < kPlaneLengths - 1; ++i) {
    coder.bit(unary[i], length > i);
    if (length <= i) break;
  }
  if (length == 0) return;
  coder.bit(models.plane_sign[kind], steps < 0);
  if (length > 1)
    coder.bit(models.plane_top[kind][length], ((magnitude >> (length - 2)) & 1U) != 0);
  if (length > 2) coder.raw(magnitude & ((1U << (length - 2)) - 1U), length - 2);
}

inline void code_plane(RangeEncoder& coder, TileModels& models, const PlaneContexts& contexts,
                       const FlatCode& code) noexcept {
  code_plane_steps(coder, models, 0, contexts.offset, code.offset);
  code_plane_steps(coder, models, 1, contexts.dx(code.offset), code.dx);
  code_plane_steps(coder, models, 2, contexts.dy(code.dx), code.dy);
}

/// Bits of a rectangle; its height is the last of them.
inline int rect_bits(const CameraModel& camera) noexcept {
  const int xb = position_bits(blocks_wide(camera));
  const int yb = position_bits(blocks_high(camera));
  return xb + yb + std::min(xb, 8) + std::min(yb, 8);
}

inline void code_rect(RangeEncoder& coder, const CameraModel& camera,
                      const TileRect& rect) noexcept {
  const int xb = position_bits(blocks_wide(camera));
  const int yb = position_bits(blocks_high(camera));
  coder.raw(rect.bx, xb);
  coder.raw(rect.by, yb);
  coder.raw(rect.bw - 1, std::min(xb, 8));
  coder.raw(rect.bh - 1, std::min(yb, 8));
}

}  // namespace planecast
