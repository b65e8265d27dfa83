// PCG32 (O'Neill 2014, XSH-RR 64/32): the one generator of the project, the same on every machine.
#pragma once

#include <cstdint>

namespace planecast {

class Pcg32 {
 public:
  explicit Pcg32(std::uint64_t seed, std::uint64_t stream = 1) noexcept
      : increment_((stream << 1U) | 1U) {
    next();
    state_ += seed;
    next();
  }

  /// Uniform over all 32-bit values.
  std::uint32_t next() noexcept {
    const std::uint64_t old = state_;
    state_ = old * 6364136223846793005ULL + increment_;
    const auto shifted = static_cast<std::uint32_t>(((old >> 18U) ^ old) >> 27U);
    const auto rotation = static_cast<std::uint32_t>(old >> 59U);
    return (shifted >> rotation) | (shifted << ((32U - rotation) & 31U));
  }

  /// Uniform in [0, bound) by rejection, bound > 0: no modulo bias, integers only.
  std::uint32_t below(std::uint32_t bound) noexcept {
    const std::uint32_t threshold = (0U - bound) % bound;
    for (;;) {
      const std::uint32_t value = next();
      if (value >= threshold) return value % bound;
    }
  }

  /// Uniform in [0, 1) with 32 bits; for simulators and tests, never for decoded geometry.
  double uniform() noexcept { return next() * 0x1p-32; }

 private:
  std::uint64_t state_ = 0;
  std::uint64_t increment_;
};

}  // namespace planecast
