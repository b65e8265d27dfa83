// Probability models of a coded point slice (docs/wire-format.md, "Point
// tile").
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/wire/bit_mixer.hpp"
#include "core/wire/bit_model.hpp"

namespace planecast {

inline constexpr std::size_t kFaceStates = 27;  ///< three outer faces: empty, not known yet, full
inline constexpr std::size_t kSiblingStates = 256;
inline constexpr std::size_t kKnownWeights = 40;
inline constexpr std::size_t kUnknownCounts = 16;
inline constexpr std::size_t kPlaneKinds = 15;  ///< neighbours (3) by flatness (5)
inline constexpr std::size_t kPlaneDistances = 16;

/// Models of one kind of level.
struct OccupancyModels {
  MixedModel faces[kFaceStates][kSiblingStates];
  MixedModel around[kKnownWeights][kUnknownCounts];
  MixedModel plane[kPlaneKinds][kPlaneDistances][3];
};

inline constexpr std::size_t kSizeSlots = 33;
inline constexpr std::size_t kExtraContexts = 20;

struct PointModels {
  PointModels() noexcept;  ///< nothing known; not inline, which would be a kilobyte each

  OccupancyModels occupancy[2];                     ///< the last level, and those above
  BitModel single[32];                              ///< a lone node holds one point, by level
  BitModel extra_size[kExtraContexts][kSizeSlots];  ///< bit length of a group's
                                                    ///< extra points, unary
  BitModel extra_top[kSizeSlots];                   ///< the bit below the leading one
};

/// Weights of the mixed occupancy decisions.
struct PointMixers {
  BitMixer<3> occupancy[2][kPlaneKinds];
};

inline constexpr std::size_t kOccupancyModelCount =
    2 * sizeof(OccupancyModels) / sizeof(MixedModel);
inline constexpr std::size_t kCountModelCount =
    (sizeof(PointModels) - 2 * sizeof(OccupancyModels)) / sizeof(BitModel);
inline constexpr std::size_t kPointWeightCount = sizeof(PointMixers) / sizeof(std::int32_t);

/// What every slice starts from, trained by bench/train_points.
const PointModels& trained_point_models() noexcept;
const PointMixers& trained_point_mixers() noexcept;

}  // namespace planecast
