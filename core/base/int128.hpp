// Signed 128-bit integers on every machine: the compiler's own where it has them (64-bit machines),
// else two halves. Both give the same results; tables of a decoder are built with them.
#pragma once

#include <bit>
#include <compare>
#include <concepts>
#include <cstdint>

namespace planecast {

/// 128 bits in two's complement, as +, -, *, /, << and >> of the compiler's own: products and sums
/// wrap, division cuts towards zero, >> keeps the sign. Shifts by 0..127; division by 0 gives 0.
class SoftInt128 {
 public:
  constexpr SoftInt128() noexcept = default;
  template <std::integral T>
  constexpr SoftInt128(T value) noexcept  // NOLINT(google-explicit-constructor): as an integer
      : low_(static_cast<std::uint64_t>(value)), high_(value < 0 ? ~std::uint64_t{0} : 0) {}

  template <std::integral T>
  constexpr explicit operator T() const noexcept {
    return static_cast<T>(low_);
  }

  friend constexpr SoftInt128 operator+(SoftInt128 a, SoftInt128 b) noexcept {
    const std::uint64_t low = a.low_ + b.low_;
    return {low, a.high_ + b.high_ + (low < a.low_ ? 1U : 0U)};
  }
  friend constexpr SoftInt128 operator-(SoftInt128 a) noexcept {
    return SoftInt128(~a.low_, ~a.high_) + 1;
  }
  friend constexpr SoftInt128 operator-(SoftInt128 a, SoftInt128 b) noexcept { return a + -b; }
  friend constexpr SoftInt128 operator*(SoftInt128 a, SoftInt128 b) noexcept {
    const std::uint64_t a0 = a.low_ & kHalf, a1 = a.low_ >> 32U;
    const std::uint64_t b0 = b.low_ & kHalf, b1 = b.low_ >> 32U;
    const std::uint64_t bottom = a0 * b0;
    const std::uint64_t middle = a1 * b0 + (bottom >> 32U);
    const std::uint64_t other = a0 * b1 + (middle & kHalf);
    const std::uint64_t top = a1 * b1 + (middle >> 32U) + (other >> 32U);
    return {(other << 32U) | (bottom & kHalf), top + a.high_ * b.low_ + a.low_ * b.high_};
  }
  friend constexpr SoftInt128 operator/(SoftInt128 a, SoftInt128 b) noexcept {
    const SoftInt128 quotient = divide(a.negative() ? -a : a, b.negative() ? -b : b);
    return a.negative() != b.negative() ? -quotient : quotient;
  }
  friend constexpr SoftInt128 operator<<(SoftInt128 a, int bits) noexcept {
    if (bits == 0) return a;
    if (bits >= 64) return {0, a.low_ << (bits - 64)};
    return {a.low_ << bits, (a.high_ << bits) | (a.low_ >> (64 - bits))};
  }
  friend constexpr SoftInt128 operator>>(SoftInt128 a, int bits) noexcept {
    const auto high = static_cast<std::int64_t>(a.high_);
    if (bits == 0) return a;
    if (bits >= 64) return high >> (bits - 64);
    return {(a.low_ >> bits) | (a.high_ << (64 - bits)), static_cast<std::uint64_t>(high >> bits)};
  }

  friend constexpr bool operator==(SoftInt128, SoftInt128) noexcept = default;
  friend constexpr std::strong_ordering operator<=>(SoftInt128 a, SoftInt128 b) noexcept {
    if (a.negative() != b.negative())
      return a.negative() ? std::strong_ordering::less : std::strong_ordering::greater;
    return a.high_ != b.high_ ? a.high_ <=> b.high_ : a.low_ <=> b.low_;
  }

 private:
  static constexpr std::uint64_t kHalf = 0xffffffffU;

  constexpr SoftInt128(std::uint64_t low, std::uint64_t high) noexcept : low_(low), high_(high) {}
  constexpr bool negative() const noexcept { return (high_ >> 63U) != 0; }
  constexpr int bits() const noexcept {
    return high_ != 0 ? 64 + static_cast<int>(std::bit_width(high_))
                      : static_cast<int>(std::bit_width(low_));
  }
  constexpr bool below(SoftInt128 other) const noexcept {  // as unsigned
    return high_ != other.high_ ? high_ < other.high_ : low_ < other.low_;
  }

  // Of unsigned numbers, a bit of the quotient a step.
  static constexpr SoftInt128 divide(SoftInt128 a, SoftInt128 b) noexcept {
    SoftInt128 quotient;
    if (b == 0) return quotient;
    if (a.high_ == 0 && b.high_ == 0) return {a.low_ / b.low_, 0};
    for (int shift = a.bits() - b.bits(); shift >= 0; --shift) {
      const SoftInt128 part = b << shift;
      if (a.below(part)) continue;
      a = a - part;
      quotient = quotient + (SoftInt128(1) << shift);
    }
    return quotient;
  }

  std::uint64_t low_ = 0, high_ = 0;
};

#ifdef __SIZEOF_INT128__
__extension__ using Int128 = __int128;
#else
using Int128 = SoftInt128;
#endif

}  // namespace planecast
