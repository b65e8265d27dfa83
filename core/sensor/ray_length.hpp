// Length of a ray (x, y, 1), rounded up: turns a bound on the 3-D distance along a ray into a bound
// on depth that can only err to the safe side. Integers only.
#pragma once

#include <cstdint>

namespace planecast {

/// Smallest integer whose square is at least `value`; value < 2^63. About 30 steps, no libm.
constexpr std::uint64_t sqrt_ceil(std::uint64_t value) noexcept {
  std::uint64_t root = 0;
  std::uint64_t rest = value;
  for (std::uint64_t bit = std::uint64_t{1} << 62U; bit != 0; bit >>= 2U) {
    if (rest >= root + bit) {
      rest -= root + bit;
      root = (root >> 1U) + bit;
    } else {
      root >>= 1U;
    }
  }
  return rest == 0 ? root : root + 1;
}

/// Upper bound of |(x, y, 1)| in Q16, never below the true length and less than 2^-15 above it.
/// `x_q27`, `y_q27` as in RayTable, |x|, |y| <= 8. A depth error of e moves the point by at most
/// e * ray_length / 65536; so depth bound = floor(bound_3d * 65536 / ray_length).
constexpr std::uint32_t ray_length_q16(std::int32_t x_q27, std::int32_t y_q27) noexcept {
  const std::int64_t x = x_q27;
  const std::int64_t y = y_q27;
  const auto square_q54 = static_cast<std::uint64_t>(x * x + y * y + (std::int64_t{1} << 54U));
  return static_cast<std::uint32_t>((sqrt_ceil(square_q54) + 2047U) >> 11U);
}

}  // namespace planecast
