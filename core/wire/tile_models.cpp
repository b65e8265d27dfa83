#include "core/wire/tile_models.hpp"

#include <array>
#include <bit>
#include <type_traits>

namespace planecast {
namespace {

// A start in 16 bits: the probability of a 1 in 1/4096 above, the age's class below. Written by
// bench/train_models; see there.
constexpr std::uint16_t kStarts[2][kTileModelCount] = {
#include "core/wire/tile_models_trained.inc"
};

constexpr std::uint8_t kAges[16] = {0, 1, 2, 3, 4, 5, 6, 9, 12, 16, 22, 30, 40, 60, 80, 100};

static_assert(std::is_trivially_copyable_v<TileModels> && alignof(TileModels) == alignof(BitModel));

TileModels unfold(const std::uint16_t* starts) noexcept {
  std::array<BitModel, kTileModelCount> models;
  for (std::size_t i = 0; i < kTileModelCount; ++i) {
    const auto probability = static_cast<std::uint16_t>((starts[i] >> 4U) * 16U + 8U);
    models[i] = {probability, kAges[starts[i] & 15U]};
  }
  return std::bit_cast<TileModels>(models);
}

}  // namespace

const TileModels& trained_models(bool lossless) noexcept {
  static const TileModels kLossless = unfold(kStarts[0]);
  static const TileModels kBounded = unfold(kStarts[1]);
  return lossless ? kLossless : kBounded;
}

}  // namespace planecast
