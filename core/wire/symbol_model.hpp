// An adaptive distribution of sixteen symbols: one division and no branch to guess for what would
// be several binary decisions (docs/wire-format.md, "Probabilities"). Eight lanes at a time.
#pragma once

#include <array>
#include <cstdint>
#include <cstring>

namespace planecast {

using Lane8 = std::int16_t __attribute__((vector_size(16)));

namespace detail {

inline constexpr int kMaxSymbolAge = 24;
inline constexpr int kSymbolTotalBits = 15;

constexpr std::array<std::uint8_t, kMaxSymbolAge + 1> make_symbol_rates() {
  std::array<std::uint8_t, kMaxSymbolAge + 1> rates{};
  for (int age = 0; age <= kMaxSymbolAge; ++age) {
    rates[static_cast<std::size_t>(age)] = static_cast<std::uint8_t>(
        age < 2 ? 2 : (age < 4 ? 3 : (age < 10 ? 4 : (age < 24 ? 5 : 6))));
  }
  return rates;
}
inline constexpr auto kSymbolRates = make_symbol_rates();

/// Where the bounds go when a symbol was seen: every other symbol keeps 8 of 32768.
struct SymbolTargets {
  alignas(16) std::int16_t of[16][16] = {};
  constexpr SymbolTargets() {
    for (int seen = 0; seen < 16; ++seen) {
      for (int i = 1; i < 16; ++i) {
        of[seen][i] = static_cast<std::int16_t>(8 * i + (i > seen ? 32768 - 128 : 0));
      }
    }
  }
};
inline constexpr SymbolTargets kSymbolTargets{};

inline Lane8 load8(const std::int16_t* from) noexcept {
  Lane8 out;
  std::memcpy(&out, from, sizeof out);
  return out;
}

/// How many leading lanes of two are set (all bits or none per lane; the set ones come first).
inline int leading_lanes(Lane8 low, Lane8 high) noexcept {
#if defined(__SSE2__)
  using Bytes = char __attribute__((vector_size(16)));
  using Short8 = short __attribute__((vector_size(16)));
  const auto bytes =
      __builtin_ia32_packsswb128(reinterpret_cast<Short8>(low), reinterpret_cast<Short8>(high));
  const auto mask =
      static_cast<std::uint32_t>(__builtin_ia32_pmovmskb128(reinterpret_cast<Bytes>(bytes)));
  return __builtin_ctz(~mask);
#else
  const Lane8 both = low + high;
  int sum = 0;
  for (int i = 0; i < 8; ++i) sum -= both[i];
  return sum;
#endif
}

}  // namespace detail

/// State of one context. bounds[i], 1..15, is the probability in 1/32768 of a symbol below i;
/// bounds[0] is the age.
struct SymbolModel {
  alignas(16) std::int16_t bounds[16] = {0,     2048,  4096,  6144,  8192,  10240, 12288, 14336,
                                         16384, 18432, 20480, 22528, 24576, 26624, 28672, 30720};

  // Without a branch: which symbol it is no processor could guess.
  std::uint32_t low(int symbol) const noexcept {
    return static_cast<std::uint32_t>(bounds[symbol]) & (0U - std::uint32_t{symbol != 0});
  }
  std::uint32_t high(int symbol) const noexcept {
    const std::uint32_t last = 0U - std::uint32_t{symbol == 15};
    return (static_cast<std::uint32_t>(bounds[(symbol + 1) & 15]) & ~last) | (32768U & last);
  }

  /// The symbol that `value`, 0 .. 32767, lies in.
  int find(std::int32_t value) const noexcept {
    const auto v = static_cast<std::int16_t>(value);
    const Lane8 all = {v, v, v, v, v, v, v, v};
    Lane8 first = detail::load8(bounds);
    first[0] = 0;  // the age is no bound
    return detail::leading_lanes(first <= all, detail::load8(bounds + 8) <= all) - 1;
  }

  void update(int symbol) noexcept {
    const int age = bounds[0];
    const int rate = detail::kSymbolRates[static_cast<std::size_t>(age)];
    const std::int16_t* target = detail::kSymbolTargets.of[symbol];
    Lane8 a = detail::load8(bounds), b = detail::load8(bounds + 8);
    a += (detail::load8(target) - a) >> rate;
    b += (detail::load8(target + 8) - b) >> rate;
    a[0] = static_cast<std::int16_t>(age + (age < detail::kMaxSymbolAge ? 1 : 0));
    std::memcpy(bounds, &a, sizeof a);  // whole, so that the next load need not wait
    std::memcpy(bounds + 8, &b, sizeof b);
  }
};

/// Two contexts of one symbol: its probabilities are the mean of theirs, rounded up, and both
/// learn. Refers to its models.
class SymbolPair {
 public:
  SymbolPair(SymbolModel& first, SymbolModel& second) noexcept : first_(first), second_(second) {}

  std::uint32_t low(int symbol) const noexcept {
    return (first_.low(symbol) + second_.low(symbol) + 1) >> 1U;
  }
  std::uint32_t high(int symbol) const noexcept {
    return (first_.high(symbol) + second_.high(symbol) + 1) >> 1U;
  }
  int find(std::int32_t value) const noexcept {
    const auto v = static_cast<std::int16_t>(value);
    const Lane8 all = {v, v, v, v, v, v, v, v};
    Lane8 low8 = mean(0);
    low8[0] = 0;  // the ages are no bound
    return detail::leading_lanes(low8 <= all, mean(8) <= all) - 1;
  }
  void update(int symbol) noexcept {
    first_.update(symbol);
    second_.update(symbol);
  }

 private:
  Lane8 mean(int at) const noexcept {
    const Lane8 a = detail::load8(first_.bounds + at), b = detail::load8(second_.bounds + at);
    return (a | b) - ((a ^ b) >> 1);
  }

  SymbolModel& first_;
  SymbolModel& second_;
};

}  // namespace planecast
