// The 128-bit integers of machines that have none do as the compiler's own.
#include "core/base/int128.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "core/base/random.hpp"

namespace planecast {
namespace {

constexpr std::int64_t kMost = std::numeric_limits<std::int64_t>::max();

TEST(Int128, KnownProductsAndQuotients) {
  const SoftInt128 product = SoftInt128(kMost) * kMost;  // 2^126 - 2^64 + 1
  EXPECT_EQ(product >> 64, SoftInt128((std::int64_t{1} << 62) - 1));
  EXPECT_EQ(static_cast<std::int64_t>(product), 1);
  EXPECT_EQ(product / kMost, SoftInt128(kMost));
  EXPECT_EQ(product / -kMost, SoftInt128(-kMost));
  EXPECT_EQ(SoftInt128(-7) / 2, SoftInt128(-3)) << "cut towards zero";
  EXPECT_EQ(SoftInt128(-7) >> 1, SoftInt128(-4)) << "rounded down";
  EXPECT_EQ(SoftInt128(5) / 0, SoftInt128(0));
  EXPECT_LT(SoftInt128(-1), SoftInt128(0));
  EXPECT_LT(SoftInt128(std::numeric_limits<std::uint64_t>::max()), SoftInt128(1) << 64);
  EXPECT_EQ((SoftInt128(-3) << 100) >> 100, SoftInt128(-3));
}

#ifdef __SIZEOF_INT128__
std::int64_t any(Pcg32& random) {
  const auto value = static_cast<std::int64_t>(std::uint64_t{random.next()} << 32U | random.next());
  return value >> random.below(64);
}

bool same(SoftInt128 a, Int128 b) {
  return static_cast<std::uint64_t>(a) == static_cast<std::uint64_t>(b) &&
         static_cast<std::int64_t>(a >> 64) == static_cast<std::int64_t>(b >> 64);
}

TEST(Int128, AgreesWithTheCompilersOwn) {
  Pcg32 random(128);
  for (int i = 0; i < 200'000; ++i) {
    const std::int64_t a = any(random), b = any(random), c = any(random), d = any(random);
    const Int128 hard = Int128{a} * b - Int128{c} * d;
    const SoftInt128 soft = SoftInt128(a) * b - SoftInt128(c) * d;
    ASSERT_TRUE(same(soft, hard)) << i;
    ASSERT_TRUE(same(-soft, -hard)) << i;
    if (d != 0) ASSERT_TRUE(same(soft / d, hard / d)) << i;
    const Int128 divisor = Int128{c} * a;
    if (divisor != 0) ASSERT_TRUE(same(soft / (SoftInt128(c) * a), hard / divisor)) << i;
    const int bits = static_cast<int>(random.below(128));
    ASSERT_TRUE(same(soft >> bits, hard >> bits)) << i;
    ASSERT_TRUE(same(SoftInt128(a) << (bits / 2), Int128{a} << (bits / 2))) << i;
    ASSERT_EQ(soft < SoftInt128(c), hard < c) << i;
    ASSERT_EQ(soft > SoftInt128(a) * d, hard > Int128{a} * d) << i;
  }
}
#endif

}  // namespace
}  // namespace planecast
