#include "core/metrics/compression.hpp"

#include <gtest/gtest.h>

namespace planecast {
namespace {

TEST(Compression, RatioIsEquation10OnTwelveBytesAPoint) {
  EXPECT_DOUBLE_EQ(ratio_percent(120, 1000), 99.0);
  EXPECT_DOUBLE_EQ(ratio_percent(12000, 1000), 0.0);
  EXPECT_DOUBLE_EQ(ratio_percent(0, 1000), 100.0);
}

TEST(Compression, RatioIsNegativeWhenPackingMakesTheFrameLarger) {
  EXPECT_DOUBLE_EQ(ratio_percent(24000, 1000), -100.0);
}

TEST(Compression, BitsPerPointCountsEightBitsAByte) {
  EXPECT_DOUBLE_EQ(bits_per_point(1000, 8000), 1.0);
  EXPECT_DOUBLE_EQ(bits_per_point(12, 1), 96.0);
}

TEST(Compression, FiguresOfLargeStreamsDoNotOverflow) {
  EXPECT_DOUBLE_EQ(ratio_percent(1ULL << 60U, 1ULL << 60U), (1.0 - 1.0 / 12.0) * 100.0);
  EXPECT_DOUBLE_EQ(bits_per_point(1ULL << 62U, 1ULL << 62U), 8.0);
}

TEST(Compression, NoPointsGiveZero) {
  EXPECT_EQ(ratio_percent(40, 0), 0.0);
  EXPECT_EQ(bits_per_point(40, 0), 0.0);
}

}  // namespace
}  // namespace planecast
