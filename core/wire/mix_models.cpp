#include "core/wire/mix_models.hpp"

#include <algorithm>

namespace planecast {
namespace {

// Starts in 16 bits: the probability of a 1 in 1/4096 above, the class of decisions seen below.
// Then the weights of the mixers, 1/256. Written by bench/train_mix; see there.
constexpr std::uint16_t kStarts[2][kMixStarts] = {
#include "core/wire/mix_models_trained.inc"
};
constexpr std::int16_t kWeights[2][kMixWeights] = {
#include "core/wire/mix_weights_trained.inc"
};

constexpr std::uint8_t kSeen[16] = {0, 1, 2, 3, 4, 6, 8, 10, 14, 18, 24, 32, 44, 60, 80, 110};

MixedModel unfold(std::uint16_t start) noexcept {
  const auto p = static_cast<std::uint16_t>((start >> 4U) * 16U + 8U);
  return {p, p, kSeen[start & 15U]};
}

// In place: the models are too many for a thread's stack.
void unfold(bool lossless, MixModels& models) noexcept {
  models.plain = trained_models(lossless);
  const std::uint16_t* start = kStarts[lossless ? 0 : 1];
  for (auto& context : models.pixel) {
    for (MixedModel& model : context) model = unfold(*start++);
  }
  constexpr int kNearest = kMaskInputContexts[0], kWide = kMaskInputContexts[kWideMask];
  for (int i = 0; i < kAllMaskContexts; ++i) {
    if (i < kNearest || i >= kNearest + kWide) {
      models.mask[i] = unfold(*start++);
    } else {
      models.mask[i] = models.mask[i % kNearest];
      models.mask[i].seen = std::min<std::uint8_t>(models.mask[i].seen, 2);
    }
  }
  const std::int16_t* weight = kWeights[lossless ? 0 : 1];
  for (auto& set : models.pixel_mixers) {
    for (auto& mixer : set) {
      for (auto& w : mixer.weight) w = *weight++ * 256;
    }
  }
  for (auto& mixer : models.mask_mixers) {
    for (auto& w : mixer.weight) w = *weight++ * 256;
  }
}

struct Trained {
  MixModels lossless, bounded;
  Trained() noexcept {
    unfold(true, lossless);
    unfold(false, bounded);
  }
};

}  // namespace

const MixModels& trained_mix_models(bool lossless) noexcept {
  static const Trained kTrained;
  return lossless ? kTrained.lossless : kTrained.bounded;
}

}  // namespace planecast
