// What is to be coded of a pixel under a bound, as a list of binary decisions: quantising finds
// them in coding order, so that coding is one loop without a question. Encoder half, seen by the
// tile packer only.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/wire/tile_models.hpp"

namespace planecast {

/// A value and the model it is coded by: the model's place in TileModels, in bytes, which is even,
/// and the value as lowest bit.
using PixelDecision = std::uint16_t;

static_assert(sizeof(BitModel) % 2 == 0 && sizeof(TileModels) < 0xffff);

/// In the place of a decision: the next jump follows.
inline constexpr PixelDecision kJumpFollows = 0xffff;

/// Most decisions of a pixel: mask, two of its surface, correction, sign, size, jump.
inline constexpr std::size_t kMostDecisions = 6 + kMaxUnary;

/// The value of model `index` of those that lie at `models` bytes in TileModels.
constexpr PixelDecision decision(std::size_t models, std::size_t index, bool value) noexcept {
  return static_cast<PixelDecision>(models + index * sizeof(BitModel) + (value ? 1U : 0U));
}

constexpr PixelDecision mask_decision(std::uint32_t context, bool reading) noexcept {
  return decision(offsetof(TileModels, mask), context, reading);
}
constexpr PixelDecision choice_decision(int surface, std::uint32_t context, bool on) noexcept {
  constexpr std::size_t kContexts = sizeof(TileModels::on_surface[0]) / sizeof(BitModel);
  return decision(offsetof(TileModels, on_surface),
                  static_cast<std::size_t>(surface) * kContexts + context, on);
}
constexpr PixelDecision correction_decision(std::uint32_t context, bool corrected) noexcept {
  return decision(offsetof(TileModels, correction), context, corrected);
}

/// "Is there a correction".
constexpr bool is_correction(PixelDecision d) noexcept {
  return d >= correction_decision(0, false) && d < correction_decision(kCorrectionContexts, false);
}
/// "Is it on this surface".
constexpr bool is_choice(PixelDecision d) noexcept {
  return d >= choice_decision(0, 0, false) && d < choice_decision(2, 0, false);
}

/// Sign and size of a correction, +-(kMaxUnary + 1) before a jump. Returns the end.
inline PixelDecision* add_correction(PixelDecision* to, std::uint32_t sign_context,
                                     std::uint32_t magnitude_context, std::int32_t steps) noexcept {
  *to++ = decision(offsetof(TileModels, sign), sign_context, steps > 0);
  const std::int32_t more = (steps < 0 ? -steps : steps) - 1;
  const std::size_t unary = std::size_t{magnitude_context} * kMaxUnary;
  for (std::int32_t i = 0; i < kMaxUnary; ++i) {
    *to++ =
        decision(offsetof(TileModels, magnitude), unary + static_cast<std::size_t>(i), more > i);
    if (more <= i) return to;
  }
  *to++ = kJumpFollows;
  return to;
}

}  // namespace planecast
