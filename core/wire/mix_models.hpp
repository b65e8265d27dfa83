// The models of a tile under `--effort best`: for each binary decision several contexts whose
// probabilities are mixed (docs/wire-format.md, "Mixed tile"). Both halves start every tile from
// the same trained constants.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/wire/mix_bit.hpp"
#include "core/wire/tile_models.hpp"

namespace planecast {

/// Contexts mixed for a decision of a correction, and of the hole mask.
inline constexpr std::size_t kPixelInputs = 8;
inline constexpr std::size_t kMaskInputs = 5;
/// Decisions of a correction: is there one, its sign, and its class in unary.
inline constexpr int kPixelSlots = 9;
/// Numbers of contexts of each input.
inline constexpr std::array<int, kPixelInputs> kPixelContexts = {96,  96,  147, 225,
                                                                 150, 128, 729, 125};
inline constexpr std::array<int, kMaskInputs> kMaskInputContexts = {256, 4096, 256, 1024, 512};
inline constexpr int kPixelMixers = 12;
inline constexpr int kMaskMixers = 16;
constexpr int first_context(const auto& counts, std::size_t input) {
  int sum = 0;
  for (std::size_t i = 0; i < input; ++i) sum += counts[i];
  return sum;
}
inline constexpr int kAllPixelContexts = first_context(kPixelContexts, kPixelInputs);
inline constexpr int kAllMaskContexts = first_context(kMaskInputContexts, kMaskInputs);

struct MixModels {
  TileModels plain;  ///< decisions of blocks and what follows a far correction
  MixedModel pixel[kAllPixelContexts][kPixelSlots];
  MixedModel mask[kAllMaskContexts];
  MixWeights<kPixelInputs> pixel_mixers[kPixelSlots][kPixelMixers];
  MixWeights<kMaskInputs> mask_mixers[kMaskMixers];
  BitModel low[4][4];  ///< bits within a class of magnitudes
};

/// Models that training gives starts to; the widest contexts of the mask start as the nearest do.
inline constexpr int kWideMask = 1;
inline constexpr std::size_t kMixStarts =
    std::size_t{kAllPixelContexts} * kPixelSlots + kAllMaskContexts - kMaskInputContexts[kWideMask];
inline constexpr std::size_t kMixWeights =
    kPixelInputs * kPixelSlots * kPixelMixers + kMaskInputs * kMaskMixers;

/// Models at the start of a tile, for lossless and for bounded streams.
const MixModels& trained_mix_models(bool lossless) noexcept;

}  // namespace planecast
