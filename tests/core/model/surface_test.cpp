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
  }
}

}  // namespace
}  // namespace planecast
