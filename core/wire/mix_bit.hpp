// Mixing for `--effort best`: the probabilities of several contexts become one in the logistic
// domain, each weighed by what it has seen and by learned weights (after Mahoney 2005). Shared by
// both halves; integers only (docs/wire-format.md, "Mixed decisions").
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "core/wire/bit_mixer.hpp"

namespace planecast {

namespace detail {

/// Share of a model's odds that count, by the decisions it has seen [Q8]: (2 n + 1) / (2 n + 3).
constexpr std::array<std::uint16_t, kMostSeen + 1> make_shares() {
  std::array<std::uint16_t, kMostSeen + 1> shares{};
  for (unsigned n = 0; n <= kMostSeen; ++n)
    shares[n] = static_cast<std::uint16_t>(256 * (2 * n + 1) / (2 * n + 3));
  return shares;
}
inline constexpr auto kShares = make_shares();

}  // namespace detail

/// Weights of the models of N contexts; they learn fast at first.
template <std::size_t N>
struct MixWeights {
  std::int32_t weight[N] = {};  ///< Q16
  std::uint16_t uses = 0;       ///< decisions weighed, saturating

  static constexpr std::int32_t kMost = 1 << 19;
  static constexpr std::uint16_t kMostUses = 1024;

  int rate() const noexcept { return uses < 64 ? 13 : (uses < kMostUses ? 14 : 15); }
};

/// What mixing found: the probability to code with, and what learning from the outcome needs.
template <std::size_t N>
struct MixedDecision {
  std::uint32_t probability = 32768;
  std::int32_t odds[N] = {};

  MixedDecision(const MixWeights<N>& weights, MixedModel* const (&models)[N]) noexcept {
    std::int64_t sum = 0;
    for (std::size_t i = 0; i < N; ++i) {
      odds[i] = models[i]->odds() * detail::kShares[models[i]->seen] >> 8U;
      sum += std::int64_t{weights.weight[i]} * odds[i];
    }
    const auto x = static_cast<std::int32_t>(std::clamp<std::int64_t>(sum >> 16U, -2047, 2047));
    probability = detail::kSquash[static_cast<std::size_t>(x + 2048)];
  }

  void learn(MixWeights<N>& weights, MixedModel* const (&models)[N], bool bit) const noexcept {
    const std::int32_t error = (bit ? 65536 : 0) - static_cast<std::int32_t>(probability);
    const int rate = weights.rate();
    for (std::size_t i = 0; i < N; ++i) {
      const std::int32_t moved =
          weights.weight[i] + ((odds[i] * error + (1 << (rate - 1))) >> rate);
      weights.weight[i] = std::clamp(moved, -MixWeights<N>::kMost, MixWeights<N>::kMost);
      models[i]->update(bit);
    }
    if (weights.uses < MixWeights<N>::kMostUses) ++weights.uses;
  }
};

}  // namespace planecast
