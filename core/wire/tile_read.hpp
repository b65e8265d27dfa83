// Composite symbols of a tile, read: the mirror of tile_write.hpp (docs/wire-format.md, "Tile").
// Decoder half: nothing is believed before it is bounded.
#pragma once

#include <algorithm>
#include <cstdint>

#include "core/base/status.hpp"
#include "core/wire/range_decoder.hpp"
#include "core/wire/tile_models.hpp"
#include "core/wire/tile_syntax.hpp"

namespace planecast {

inline Status read_coefficient(RangeDecoder& coder, int shift, std::int32_t& value) noexcept {
  const auto length = static_cast<int>(coder.raw(5));
  value = 0;
  if (length == 0) return Status::kOk;
  if (length + shift > 30) return Status::kFieldRange;
  const bool negative = coder.raw(1) != 0;
  std::uint32_t magnitude = length > 16 ? coder.raw(length - 16) : 0;
  const int low = std::min(length, 16);
  magnitude = (magnitude << low) | coder.raw(low);
  value = static_cast<std::int32_t>(magnitude << shift);
  if (negative) value = -value;
  return Status::kOk;
}

inline Status read_surface(RangeDecoder& coder, int shift, Surface& out) noexcept {
  const int degree = coder.raw(1) != 0 ? 2 : 1;
  out = {};
  constexpr std::int32_t Surface::*kCoefficients[] = {&Surface::a, &Surface::b, &Surface::c,
                                                      &Surface::d, &Surface::e, &Surface::f};
  for (int i = 0; i < 3 * degree; ++i) {
    const Status status = read_coefficient(coder, shift, out.*kCoefficients[i]);
    if (status != Status::kOk) return status;
  }
  return Status::kOk;
}

inline std::uint32_t read_tree(RangeDecoder& coder, BitModel* models, int bits) noexcept {
  std::uint32_t node = 1;
  for (int i = 0; i < bits; ++i) node = node * 2 + (coder.bit(models[node]) ? 1 : 0);
  return node - (1U << bits);
}

/// Steps of one number of a plane, |steps| < 2^(kPlaneLengths - 1).
inline std::int32_t read_plane_steps(RangeDecoder& coder, TileModels& models, int kind,
                                     int context) noexcept {
  BitModel* unary = models.plane_length[kind][context];
  int length = 0;
  while (length < kPlaneLengths - 1 && coder.bit(unary[length])) ++length;
  if (length == 0) return 0;
  const bool negative = coder.bit(models.plane_sign[kind]);
  std::int32_t steps = 1;
  if (length > 1) steps = 2 + (coder.bit(models.plane_top[kind][length]) ? 1 : 0);
  if (length > 2)
    steps = (steps << (length - 2)) + static_cast<std::int32_t>(coder.raw(length - 2));
  return negative ? -steps : steps;
}

/// The plane of a flat block.
inline BlockPlane read_plane(RangeDecoder& coder, TileModels& models, const PlaneHints& hints,
                             const std::uint8_t* half_widths, std::int32_t last_level) noexcept {
  const BlockPlane foretold = foretell_plane(hints, half_widths, last_level);
  const PlaneSteps steps(half_widths[(foretold.middle + 128) >> 8]);
  const PlaneContexts contexts(hints);
  const std::int32_t offset = read_plane_steps(coder, models, 0, contexts.offset);
  const std::int32_t dx = read_plane_steps(coder, models, 1, contexts.dx(offset));
  const std::int32_t dy = read_plane_steps(coder, models, 2, contexts.dy(dx));
  return BlockPlane::clamped(foretold.middle + offset * steps.offset,
                             foretold.dx + dx * steps.slope, foretold.dy + dy * steps.slope,
                             last_level);
}

}  // namespace planecast
