#include "core/wire/point_models.hpp"

#include <array>
#include <bit>
#include <type_traits>

#include "core/wire/start_reader.hpp"

namespace planecast {
namespace {

// A start in 16 bits: the probability of a 1 in 1/4096 above, the class of decisions seen below;
// occupancy, then counts. Written by bench/pack_starts from point_occupancy_trained.inc and
// point_counts_trained.inc. The weights of the mixers are bench/train_points'.
constexpr std::uint8_t kPackedPoints[] = {
#include "core/wire/point_models_packed.inc"
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
  StartReader reader(kPackedPoints);
  StartWordReader words(reader);
  words.set_stride(kSiblingStates);
  auto* occupancy = reinterpret_cast<MixedModel*>(&models.occupancy);
  for (std::size_t i = 0; i < kOccupancyModelCount; ++i) {
    const std::uint16_t start = words.next(), p = probability(start);
    occupancy[i] = {p, p, kSeen[start & 15U]};
  }
  words.set_stride(1);
  auto* counts = reinterpret_cast<BitModel*>(&models.single);
  for (std::size_t i = 0; i < kCountModelCount; ++i) {
    const std::uint16_t start = words.next();
    counts[i] = {probability(start), kAges[start & 15U]};
  }
  return models;
}

PointMixers unfold_weights() noexcept {
  std::array<std::int32_t, kPointWeightCount> weights;
  for (std::size_t i = 0; i < kPointWeightCount; ++i) weights[i] = kWeights[i];
  return std::bit_cast<PointMixers>(weights);
}

}  // namespace

PointModels::PointModels() noexcept = default;

const PointModels& trained_point_models() noexcept {
  static const PointModels kModels = unfold();
  return kModels;
}

const PointMixers& trained_point_mixers() noexcept {
  static const PointMixers kMixers = unfold_weights();
  return kMixers;
}

}  // namespace planecast
