#include "core/wire/point_models.hpp"

#include <array>
#include <bit>
#include <type_traits>

namespace planecast {
namespace {

// A start in 16 bits: the probability of a 1 in 1/4096 above, the class of
// decisions seen below. Then the weights of the mixers. Written by
// bench/train_points; see there.
constexpr std::uint16_t kOccupancyStarts[kOccupancyModelCount] = {
#include "core/wire/point_occupancy_trained.inc"
};
constexpr std::uint16_t kCountStarts[kCountModelCount] = {
#include "core/wire/point_counts_trained.inc"
};
constexpr std::int32_t kWeights[kPointWeightCount] = {
#include "core/wire/point_weights_trained.inc"
};

// Half of the trust that training found: a little better in short slices.
constexpr std::uint8_t kSeen[16] = {0, 1, 1, 1, 2, 2, 3, 4, 5, 6, 8, 10, 13, 17, 23, 30};
constexpr std::uint8_t kAges[16] = {0, 1, 2, 3, 4, 5, 6, 9, 12, 16, 22, 30, 40, 60, 80, 100};

static_assert(std::is_trivially_copyable_v<PointModels> &&
              alignof(PointModels) == alignof(BitModel));

std::uint16_t probability(std::uint16_t start) noexcept {
  return static_cast<std::uint16_t>((start >> 4U) * 16U + 8U);
}

// In place: the models are too many for a thread's stack.
PointModels unfold() noexcept {
  PointModels models;
  auto* occupancy = reinterpret_cast<MixedModel*>(&models.occupancy);
  for (std::size_t i = 0; i < kOccupancyModelCount; ++i) {
    const std::uint16_t p = probability(kOccupancyStarts[i]);
    occupancy[i] = {p, p, kSeen[kOccupancyStarts[i] & 15U]};
  }
  auto* counts = reinterpret_cast<BitModel*>(&models.single);
  for (std::size_t i = 0; i < kCountModelCount; ++i) {
    const std::uint16_t p = probability(kCountStarts[i]);
    counts[i] = {p, kAges[kCountStarts[i] & 15U]};
  }
  return models;
}

PointMixers unfold_weights() noexcept {
  std::array<std::int32_t, kPointWeightCount> weights;
  for (std::size_t i = 0; i < kPointWeightCount; ++i) weights[i] = kWeights[i];
  return std::bit_cast<PointMixers>(weights);
}

}  // namespace

const PointModels& trained_point_models() noexcept {
  static const PointModels kModels = unfold();
  return kModels;
}

const PointMixers& trained_point_mixers() noexcept {
  static const PointMixers kMixers = unfold_weights();
  return kMixers;
}

}  // namespace planecast
