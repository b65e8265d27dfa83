// The inverse depth of a surface in integers against exact arithmetic.
#include "core/model/surface.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/int128.hpp"
#include "core/base/random.hpp"

namespace planecast {
namespace {

TEST(Surface, InverseDepthIsTheFloorOfTheExactValueEvenAtTheLimits) {
  Pcg32 random(5);
  for (int i = 0; i < 20000; ++i) {
    const auto coefficient = [&] {
      const auto magnitude = static_cast<std::int32_t>(
          random.below(4) == 0 ? kMaxSurfaceCoefficient : random.next() >> (2 + random.below(30)));
      return random.below(2) != 0 ? magnitude : -magnitude;
    };
    const auto ray = [&] {
      return static_cast<std::int32_t>(random.below((2U << 30U) + 1U)) - (1 << 30);
    };
    const Surface s{coefficient(), coefficient(), coefficient()};
    const std::int32_t x = i % 5 == 0 ? (1 << 30) : ray(), y = i % 7 == 0 ? -(1 << 30) : ray();
    const Int128 exact = Int128{s.a} * x + Int128{s.b} * y + (Int128{s.c} << 27);
    EXPECT_EQ(Int128{s.inverse_depth(x, y)}, exact >> 27) << i;
    EXPECT_LT(std::abs(s.inverse_depth(x, y)), std::int64_t{1} << 36);
    Surface bent = s;
    bent.d = coefficient();
    bent.e = coefficient();
    bent.f = coefficient();
    // Rays are cut to Q21 and their products to Q22 before they meet the coefficients.
    const auto product = [](std::int32_t p, std::int32_t q) {
      return (Int128{p >> 6} * (q >> 6)) >> 20;
    };
    const Int128 bend = Int128{bent.d} * product(x, x) + Int128{bent.e} * product(x, y) +
                        Int128{bent.f} * product(y, y);
    EXPECT_EQ(Int128{bent.inverse_depth(x, y)}, (exact >> 27) + (bend >> 22)) << i;
    EXPECT_LT(std::abs(bent.inverse_depth(x, y)), std::int64_t{1} << 39);
  }
}

TEST(Surface, DegreeTwoFollowsItsPolynomialWithinAFewSteps) {
  Pcg32 random(6);
  for (int i = 0; i < 20000; ++i) {
    const auto within = [&](double size) { return size * (2 * random.uniform() - 1); };
    const double x = within(1.5), y = within(1.5);
    const auto at = [](double v, double one) { return static_cast<std::int32_t>(v * one); };
    const Surface s{at(within(1), 0x1p23), at(within(1), 0x1p23), at(within(1), 0x1p23),
                    at(within(1), 0x1p23), at(within(1), 0x1p23), at(within(1), 0x1p23)};
    const double exact = x * (s.a + s.d * x + s.e * y) + y * (s.b + s.f * y) + s.c;
    const std::int64_t found = s.inverse_depth(at(x, 0x1p27), at(y, 0x1p27));
    EXPECT_NEAR(static_cast<double>(found), exact, 100) << i;
  }
}

}  // namespace
}  // namespace planecast
