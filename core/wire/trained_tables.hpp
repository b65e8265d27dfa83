// The trained starts of models as tables, as training wrote them and docs/wire-format.md gives
// them. Only packing them (bench/pack_starts) and tests see these: the library holds them packed.
#pragma once

#include <cstdint>

#include "core/wire/mix_models.hpp"
#include "core/wire/point_models.hpp"
#include "core/wire/residual_models.hpp"
#include "core/wire/tile_models.hpp"

namespace planecast::trained {

// Sets of two: lossless, then bounded; of residuals: levels on a lattice, then every count.
inline constexpr std::uint16_t kTile[2][kTileModelCount] = {
#include "core/wire/tile_models_trained.inc"
};
inline constexpr std::uint16_t kMixed[2][kMixStarts] = {
#include "core/wire/mix_models_trained.inc"
};
inline constexpr std::int16_t kMixedWeights[2][kMixWeights] = {
#include "core/wire/mix_weights_trained.inc"
};
inline constexpr std::uint16_t kOccupancy[kOccupancyModelCount] = {
#include "core/wire/point_occupancy_trained.inc"
};
inline constexpr std::uint16_t kCounts[kCountModelCount] = {
#include "core/wire/point_counts_trained.inc"
};
inline constexpr ResidualModels kResiduals[2] = {
#include "core/wire/residual_models_trained.inc"
};

}  // namespace planecast::trained
