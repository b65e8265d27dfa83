// An adaptive probability of one binary decision: the mean of a fast and a slow estimate, both
// quick while young. Starts come from trained constants, so that a slice of 1200 B costs little.
#pragma once

#include <array>
#include <cstdint>

namespace planecast {

namespace detail {

inline constexpr int kMaxBitAge = 126;

/// Shifts of the fast and the slow estimate by age: 1/2, 1/2, 1/3 ... while young.
constexpr std::array<std::array<std::uint8_t, 2>, kMaxBitAge + 1> make_bit_rates() {
  std::array<std::array<std::uint8_t, 2>, kMaxBitAge + 1> rates{};
  for (int age = 0; age <= kMaxBitAge; ++age) {
    const int young = 1 + age / 2;
    const int slow = age < 16 ? 4 : (age < 40 ? 5 : (age < 100 ? 6 : 7));
    rates[age][0] = static_cast<std::uint8_t>(age < 6 ? young : 4);
    rates[age][1] = static_cast<std::uint8_t>(age < 6 ? young : slow);
  }
  return rates;
}
inline constexpr auto kBitRates = make_bit_rates();

}  // namespace detail

/// State of one context. Probabilities of a 1 in 1/65536.
struct BitModel {
  std::uint16_t fast = 32768;
  std::uint16_t slow = 32768;
  std::uint8_t age = 0;  ///< decisions seen, saturating; a trained start is older

  /// Probability of a 1 in 1/65536, kept off the ends so that no decision costs over 11 bits.
  std::uint32_t probability() const noexcept {
    const std::uint32_t p = (std::uint32_t{fast} + slow) >> 1U;
    return p < 32 ? 32 : (p > 65504 ? 65504 : p);
  }

  void update(bool bit) noexcept {
    const unsigned fast_rate = detail::kBitRates[age][0];
    const unsigned slow_rate = detail::kBitRates[age][1];
    // 65535 - p is ~p: towards a 1 the same step is taken from the other end.
    const std::uint32_t turn = bit ? 0xffffU : 0U;
    const std::uint32_t f = fast ^ turn, s = slow ^ turn;
    fast = static_cast<std::uint16_t>((f - (f >> fast_rate)) ^ turn);
    slow = static_cast<std::uint16_t>((s - (s >> slow_rate)) ^ turn);
    if (age < detail::kMaxBitAge) ++age;
  }
};

}  // namespace planecast
