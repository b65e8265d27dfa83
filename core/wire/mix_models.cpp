#include "core/wire/mix_models.hpp"

#include <algorithm>

#include "core/wire/start_reader.hpp"

namespace planecast {
namespace {

// Starts in 16 bits: the probability of a 1 in 1/4096 above, the class of decisions seen below.
// Then the weights of the mixers, 1/256. Written by bench/pack_starts from mix_models_trained.inc
// and mix_weights_trained.inc.
constexpr std::uint8_t kPackedMixes[] = {
#include "core/wire/mix_models_packed.inc"
};

constexpr std::uint8_t kSeen[16] = {0, 1, 2, 3, 4, 6, 8, 10, 14, 18, 24, 32, 44, 60, 80, 110};

MixedModel unfold(std::uint16_t start) noexcept {
  const auto p = static_cast<std::uint16_t>((start >> 4U) * 16U + 8U);
  return {p, p, kSeen[start & 15U]};
}

void unfold_weights(StartWordReader& words, MixModels& models) noexcept {
  for (auto& set : models.pixel_mixers) {
    for (auto& mixer : set) {
      for (auto& w : mixer.weight) w = words.next_weight() * 256;
    }
  }
  for (auto& mixer : models.mask_mixers) {
    for (auto& w : mixer.weight) w = words.next_weight() * 256;
  }
}

struct Trained {
  MixModels lossless, bounded;

  // In place: the models are too many for a thread's stack.
  Trained() noexcept {
    lossless.plain = trained_models(true);
    bounded.plain = trained_models(false);
    StartReader reader(kPackedMixes);
    StartWordReader words(reader);
    const auto next = [&](MixedModel& first, MixedModel& second) {
      const auto starts = words.next_of_both();
      first = unfold(starts[0]);
      second = unfold(starts[1]);
    };
    words.set_stride(kPixelSlots);
    for (int c = 0; c < kAllPixelContexts; ++c) {
      for (int slot = 0; slot < kPixelSlots; ++slot)
        next(lossless.pixel[c][slot], bounded.pixel[c][slot]);
    }
    words.set_stride(1);
    constexpr int kNearest = kMaskInputContexts[0], kWide = kMaskInputContexts[kWideMask];
    for (int i = 0; i < kAllMaskContexts; ++i) {
      if (i < kNearest || i >= kNearest + kWide) {
        next(lossless.mask[i], bounded.mask[i]);
        continue;
      }
      for (MixedModel* mask : {lossless.mask, bounded.mask}) {
        mask[i] = mask[i % kNearest];
        mask[i].seen = std::min<std::uint8_t>(mask[i].seen, 2);
      }
    }
    words.set_stride(kPixelInputs);
    unfold_weights(words, lossless);
    unfold_weights(words, bounded);
  }
};

}  // namespace

const MixModels& trained_mix_models(bool lossless) noexcept {
  static const Trained kTrained;
  return lossless ? kTrained.lossless : kTrained.bounded;
}

}  // namespace planecast
