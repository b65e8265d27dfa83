#include "core/wire/tile_models.hpp"

#include <cstddef>
#include <type_traits>

#include "core/wire/start_reader.hpp"

namespace planecast {
namespace {

// A start in 16 bits: the probability of a 1 in 1/4096 above, the age's class below. Written by
// bench/pack_starts from tile_models_trained.inc.
constexpr std::uint8_t kPackedTiles[] = {
#include "core/wire/tile_models_packed.inc"
};

constexpr std::uint8_t kAges[16] = {0, 1, 2, 3, 4, 5, 6, 9, 12, 16, 22, 30, 40, 60, 80, 100};

static_assert(std::is_trivially_copyable_v<TileModels> && alignof(TileModels) == alignof(BitModel));

struct Trained {
  TileModels lossless, bounded;
  Trained() noexcept {
    BitModel* const sets[2] = {reinterpret_cast<BitModel*>(&lossless),
                               reinterpret_cast<BitModel*>(&bounded)};
    StartReader reader(kPackedTiles);
    StartWordReader words(reader);
    for (std::size_t i = 0; i < kTileModelCount; ++i) {
      const auto starts = words.next_of_both();
      for (std::size_t set = 0; set < 2; ++set) {
        const auto probability = static_cast<std::uint16_t>((starts[set] >> 4U) * 16U + 8U);
        sets[set][i] = {probability, kAges[starts[set] & 15U]};
      }
    }
  }
};

}  // namespace

TileModels::TileModels() noexcept = default;

const TileModels& trained_models(bool lossless) noexcept {
  static const Trained kTrained;
  return lossless ? kTrained.lossless : kTrained.bounded;
}

}  // namespace planecast
