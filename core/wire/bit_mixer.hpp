// Mixes the probabilities of several models into one, in the logistic domain, with weights that
// follow what each model was worth (after Mahoney 2005). Shared by both halves; integers only
// (docs/wire-format.md, "Mixing").
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace planecast {

namespace detail {

inline constexpr unsigned kMostSeen = 150;
inline constexpr unsigned kMostFast = 14;

/// How far the two estimates move to the outcome [Q16], and how many decisions were seen then.
struct MixedRate {
  std::uint16_t fast, slow, next, room;
};

// Tables that are computed when the program starts, in bit_mixer.cpp: 17 kB that a board's flash
// need not hold.

/// By the decisions seen: 1/1.6, 1/2.6, ... The fast one ends at 1/15.6.
extern const std::array<MixedRate, kMostSeen + 1> kMixedRates;

/// 65536 / (1 + exp(-x)) at x = -8, -7.5, ... 8.
inline constexpr std::array<std::uint16_t, 33> kLogistic = {
    22,    36,    60,    98,    162,   267,   439,   720,   1179,  1921,  3108,
    4971,  7812,  11955, 17625, 24743, 32768, 40793, 47911, 53581, 57724, 60565,
    62428, 63615, 64357, 64816, 65097, 65269, 65374, 65438, 65476, 65500, 65514};

}  // namespace detail

/// Probability in 1/65536 of log odds `x` in 1/256, -2047 .. 2047, as the document defines it.
constexpr std::uint32_t squash(std::int32_t x) noexcept {
  const auto up = static_cast<std::uint32_t>(x + 2048);
  const std::uint32_t i = up >> 7U, part = up & 127U;
  return (detail::kLogistic[i] * (128 - part) + detail::kLogistic[i + 1] * part + 64) >> 7U;
}

namespace detail {

/// Log odds in 1/256 of a probability in 1/4096: the least x whose squash reaches it.
extern const std::array<std::int16_t, 4096> kStretch;
/// squash() of x - 2048, kept off the ends so that no decision costs over 11 bits.
extern const std::array<std::uint16_t, 4096> kSquash;

}  // namespace detail

/// Probability of a decision that is mixed: the mean of two estimates, both of all that was seen
/// while young, later one that forgets fast and one that forgets slowly.
struct MixedModel {
  std::uint16_t fast = 32768;  ///< probabilities of a 1 in 1/65536
  std::uint16_t slow = 32768;
  std::uint8_t seen = 0;  ///< decisions, saturating; a trained start has some

  std::int32_t odds() const noexcept {
    return detail::kStretch[(std::uint32_t{fast} + slow) >> 5U];
  }
  /// Towards 65535 or 0 by the share of the way that its rate says, rounded down.
  void update(bool bit) noexcept {
    // Of 65535 - p for a 1, of p for a 0: both go to 0, and 32 bits hold the product.
    const std::uint32_t flip = bit ? 0xffffU : 0, up = bit ? 0 : 0xffffU;
    const detail::MixedRate& rate = detail::kMixedRates[seen];
    const std::uint32_t f = fast ^ flip, s = slow ^ flip;
    fast = static_cast<std::uint16_t>((f - ((f * rate.fast + up) >> 16U)) ^ flip);
    slow = static_cast<std::uint16_t>((s - ((s * rate.slow + up) >> 16U)) ^ flip);
    seen = static_cast<std::uint8_t>(rate.next);
  }
};

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

  MixedBit(const BitMixer<N>& mixer, MixedModel* const (&models)[N]) noexcept {
    std::int64_t sum = 0;
    for (std::size_t i = 0; i < N; ++i) {
      odds[i] = models[i]->odds();
      sum += std::int64_t{mixer.weight[i]} * odds[i];
    }
    const auto x = static_cast<std::int32_t>(std::clamp<std::int64_t>(sum >> 16U, -2047, 2047));
    probability = detail::kSquash[static_cast<std::size_t>(x + 2048)];
  }

  void learn(BitMixer<N>& mixer, MixedModel* const (&models)[N], bool bit) const noexcept {
    const std::int32_t error = (bit ? 65536 : 0) - static_cast<std::int32_t>(probability);
    for (std::size_t i = 0; i < N; ++i) {
      const std::int32_t moved = mixer.weight[i] + ((odds[i] * error + 16384) >> 15U);
      mixer.weight[i] = std::clamp(moved, -BitMixer<N>::kMost, BitMixer<N>::kMost);
      models[i]->update(bit);
    }
  }
};

}  // namespace planecast
