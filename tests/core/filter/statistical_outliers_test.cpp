// The statistical cut against its definition.
#include "core/filter/statistical_outliers.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "core/base/random.hpp"

namespace planecast {
namespace {

TEST(StatisticalOutliers, FlagsWhatTheDefinitionFlags) {
  Pcg32 random(1);
  std::vector<float> distances;
  for (int i = 0; i < 500; ++i)
    distances.push_back(static_cast<float>(0.01 + 0.01 * random.uniform() * random.uniform()));
  distances[7] = 0.2F;
  for (const double deviations : {0.0, 0.5, 1.0, 3.0}) {
    double mean = 0, squares = 0;
    for (const float d : distances) mean += d / 500.0;
    for (const float d : distances) squares += (d - mean) * (d - mean);
    const double cut = mean + deviations * std::sqrt(squares / 499);
    std::vector<std::uint8_t> flags(500);
    StatisticalCut found;
    ASSERT_EQ(flag_statistical_outliers(distances, deviations, flags, found), Status::kOk);
    EXPECT_NEAR(found.cut, cut, 1e-12);
    std::uint32_t outliers = 0;
    for (std::size_t i = 0; i < 500; ++i) {
      ASSERT_EQ(flags[i] != 0, distances[i] > found.cut);
      outliers += flags[i];
    }
    EXPECT_EQ(found.outliers, outliers);
    EXPECT_EQ(flags[7], 1);
  }
}

TEST(StatisticalOutliers, EqualDistancesAndFewPointsHaveNone) {
  for (const std::size_t n : {0U, 1U, 2U, 10U}) {
    const std::vector<float> distances(n, 0.5F);
    std::vector<std::uint8_t> flags(n, 1);
    StatisticalCut cut;
    ASSERT_EQ(flag_statistical_outliers(distances, 1.0, flags, cut), Status::kOk);
    EXPECT_EQ(cut.outliers, 0U);
    for (const std::uint8_t flag : flags) EXPECT_EQ(flag, 0);
  }
}

TEST(StatisticalOutliers, RefusesBadOptions) {
  const std::vector<float> distances(3, 1);
  std::vector<std::uint8_t> flags(3), few(2);
  StatisticalCut cut;
  EXPECT_EQ(flag_statistical_outliers(distances, -1, flags, cut), Status::kBadConfig);
  EXPECT_EQ(
      flag_statistical_outliers(distances, std::numeric_limits<double>::quiet_NaN(), flags, cut),
      Status::kBadConfig);
  EXPECT_EQ(flag_statistical_outliers(distances, 1, few, cut), Status::kWrongSize);
}

}  // namespace
}  // namespace planecast
