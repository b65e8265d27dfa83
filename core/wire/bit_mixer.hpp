// Mixes the probabilities of several models into one, in the logistic domain, with weights that
// follow what each model was worth (after Mahoney 2005). Shared by both halves; integers only
// (docs/wire-format.md, "Mixing").
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "core/wire/bit_model.hpp"

namespace planecast {

namespace detail {

/// 65536 / (1 + exp(-x)) at x = -8, -7.5, ... 8.
inline constexpr std::array<std::uint16_t, 33> kLogistic = {
    22,    36,    60,    98,    162,   267,   439,   720,   1179,  1921,  3108,
    4971,  7812,  11955, 17625, 24743, 32768, 40793, 47911, 53581, 57724, 60565,
    62428, 63615, 64357, 64816, 65097, 65269, 65374, 65438, 65476, 65500, 65514};

}  // namespace detail

/// Probability in 1/65536 of log odds `x` in 1/256, -2047 .. 2047.
constexpr std::uint32_t squash(std::int32_t x) noexcept {
  const auto up = static_cast<std::uint32_t>(x + 2048);
  const std::uint32_t i = up >> 7U, part = up & 127U;
  return (detail::kLogistic[i] * (128 - part) + detail::kLogistic[i + 1] * part + 64) >> 7U;
}

namespace detail {

/// Log odds in 1/256 of a probability in 1/4096: the least x whose squash reaches it.
constexpr std::array<std::int16_t, 4096> make_stretch() {
  std::array<std::int16_t, 4096> table{};
  std::int32_t x = -2047;
  for (std::uint32_t p = 0; p < 4096; ++p) {
    while (x < 2047 && squash(x) < p * 16 + 8) ++x;
    table[p] = static_cast<std::int16_t>(x);
  }
  return table;
}
inline constexpr auto kStretch = make_stretch();

}  // namespace detail

/// One decision mixed from the models of N contexts.
template <std::size_t N>
struct BitMixer {
  std::int32_t weight[N];  ///< Q16

  BitMixer() noexcept { std::fill_n(weight, N, kStart); }

  static constexpr std::int32_t kStart = 26214;  // 0.4
  static constexpr std::int32_t kMost = 1 << 19;
};

/// What mixing found: the probability to code with, and what learning from the outcome needs.
template <std::size_t N>
struct MixedBit {
  std::uint32_t probability = 32768;
  std::int32_t odds[N] = {};

  MixedBit(const BitMixer<N>& mixer, BitModel* const (&models)[N]) noexcept {
    std::int64_t sum = 0;
    for (std::size_t i = 0; i < N; ++i) {
      odds[i] = detail::kStretch[models[i]->probability() >> 4U];
      sum += std::int64_t{mixer.weight[i]} * odds[i];
    }
    const auto x = static_cast<std::int32_t>(std::clamp<std::int64_t>(sum >> 16U, -2047, 2047));
    probability = std::clamp<std::uint32_t>(squash(x), 32, 65504);
  }

  void learn(BitMixer<N>& mixer, BitModel* const (&models)[N], bool bit) const noexcept {
    const std::int32_t error = (bit ? 65536 : 0) - static_cast<std::int32_t>(probability);
    for (std::size_t i = 0; i < N; ++i) {
      const std::int32_t moved = mixer.weight[i] + ((odds[i] * error + 8192) >> 14U);
      mixer.weight[i] = std::clamp(moved, -BitMixer<N>::kMost, BitMixer<N>::kMost);
      models[i]->update(bit);
    }
  }
};

}  // namespace planecast
