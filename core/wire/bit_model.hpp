// An adaptive probability of one binary decision: the mean of a fast and a slow estimate, both
// quick while young. Starts come from trained constants, so that a slice of 1200 B costs little.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace planecast {

namespace detail {

inline constexpr int kMaxBitAge = 126;

/// How a model of some age learns: the parts of 65536 by which its two estimates move, powers of
/// two, and the age after. A product keeps to one unit of the processor where a shift by a number
/// in memory takes three.
struct BitStep {
  std::uint16_t fast, slow;
  std::uint32_t next_age;
};

/// By age; an estimate moves by 1/2, 1/2, 1/4 ... while young.
constexpr std::array<BitStep, kMaxBitAge + 1> make_bit_steps() {
  std::array<BitStep, kMaxBitAge + 1> steps{};
  for (int age = 0; age <= kMaxBitAge; ++age) {
    const int young = 1 + age / 2;
    const int slow = age < 16 ? 4 : (age < 40 ? 5 : (age < 100 ? 6 : 7));
    steps[age] = {static_cast<std::uint16_t>(65536 >> (age < 6 ? young : 4)),
                  static_cast<std::uint16_t>(65536 >> (age < 6 ? young : slow)),
                  static_cast<std::uint32_t>(age < kMaxBitAge ? age + 1 : age)};
  }
  return steps;
}
inline constexpr auto kBitSteps = make_bit_steps();

}  // namespace detail

/// State of one context: two estimates of the probability of a 1, in 1/65536, and its age, in one
/// word, so that a decision loads and stores it once.
class BitModel {
 public:
  constexpr BitModel() = default;
  /// Both estimates at `probability`, 8 .. 65528; `age`: decisions seen, a trained start is older.
  constexpr BitModel(std::uint16_t probability, std::uint8_t age) noexcept
      : word_(std::uint64_t{age} << 32U | probability * 0x10001U) {}

  /// Probability of a 1 in 1/65536, never 0 or 1: an estimate stops where its step is none, at 15
  /// and 65520 unless it started beyond.
  std::uint32_t probability() const noexcept { return (fast() + slow()) >> 1U; }

  void update(bool bit) noexcept {
    const detail::BitStep& step = detail::kBitSteps[static_cast<std::size_t>(word_ >> 32U)];
    // 65535 - p is ~p: towards a 1 the same step is taken from the other end.
    const std::uint32_t turn = 0U - std::uint32_t{bit};
    const std::uint32_t both = static_cast<std::uint32_t>(word_) ^ turn;
    const std::uint32_t steps =
        ((both & 0xffffU) * step.fast) >> 16U | (((both >> 16U) * step.slow) & 0xffff0000U);
    word_ = std::uint64_t{step.next_age} << 32U | ((both - steps) ^ turn);
  }

  std::uint32_t fast() const noexcept { return word_ & 0xffffU; }
  std::uint32_t slow() const noexcept { return (word_ >> 16U) & 0xffffU; }
  /// Decisions seen, saturating.
  std::uint8_t age() const noexcept { return static_cast<std::uint8_t>(word_ >> 32U); }

 private:
  std::uint64_t word_ = 0x80008000U;  ///< the fast estimate, the slow one, the age from bit 32
};

}  // namespace planecast
