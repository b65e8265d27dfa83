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

/// State of one context: two estimates of the probability of a 1, in 1/65536, in one word, so that
/// a decision loads and stores it once.
class BitModel {
 public:
  BitModel() = default;
  /// Both estimates at `probability`, 8 .. 65528; `age`: decisions seen, a trained start is older.
  BitModel(std::uint16_t probability, std::uint8_t age) noexcept
      : estimates_(probability * 0x10001U), age_(age) {}

  /// Probability of a 1 in 1/65536, never 0 or 1: an estimate stops where its step is none, at 15
  /// and 65520 unless it started beyond.
  std::uint32_t probability() const noexcept { return (fast() + slow()) >> 1U; }

  void update(bool bit) noexcept {
    const auto& rates = detail::kBitRates[age_];
    // 65535 - p is ~p: towards a 1 the same step is taken from the other end.
    const std::uint32_t turn = 0U - std::uint32_t{bit};
    const std::uint32_t both = estimates_ ^ turn;
    const std::uint32_t steps = ((both & 0xffffU) >> rates[0]) | (both >> 16U >> rates[1]) << 16U;
    estimates_ = (both - steps) ^ turn;
    age_ = static_cast<std::uint8_t>(age_ + (age_ < detail::kMaxBitAge ? 1 : 0));
  }

  std::uint32_t fast() const noexcept { return estimates_ & 0xffffU; }
  std::uint32_t slow() const noexcept { return estimates_ >> 16U; }
  /// Decisions seen, saturating.
  std::uint8_t age() const noexcept { return age_; }

 private:
  std::uint32_t estimates_ = 0x80008000U;  ///< the slow one above
  std::uint8_t age_ = 0;
};

}  // namespace planecast
