// The noise is as large, as correlated and as often a hole as configured.
#include "core/sim/depth_noise.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

namespace planecast {
namespace {

constexpr std::uint32_t kWidth = 320, kHeight = 240;

struct Statistics {
  double mean = 0, sigma = 0;     // of the error that the test asks for
  double neighbour = 0, far = 0;  // correlation 1 and 24 pixels to the right
  double holes = 0;               // share
};

Statistics measured(const DepthNoiseConfig& config, double z,
                    const std::function<double(double)>& error_of) {
  DepthNoise noise(config, kWidth, kHeight);
  const std::vector<double> truth(kWidth * kHeight, z);
  std::vector<std::uint16_t> counts(truth.size());
  double n = 0, sum = 0, square = 0, holes = 0;
  double near_sum = 0, near_n = 0, far_sum = 0, far_n = 0;
  for (std::uint64_t frame = 0; frame < 10; ++frame) {
    Pcg32 random(frame + 1);
    noise.apply(truth, random, counts);
    for (std::size_t i = 0; i < counts.size(); ++i) {
      if (counts[i] == 0) {
        ++holes;
        continue;
      }
      const double e = error_of(counts[i] * config.metres_per_unit);
      ++n;
      sum += e;
      square += e * e;
      const std::size_t u = i % kWidth;
      if (u + 1 < kWidth && counts[i + 1] != 0) {
        near_sum += e * error_of(counts[i + 1] * config.metres_per_unit);
        ++near_n;
      }
      if (u + 24 < kWidth && counts[i + 24] != 0) {
        far_sum += e * error_of(counts[i + 24] * config.metres_per_unit);
        ++far_n;
      }
    }
  }
  Statistics out;
  out.mean = sum / n;
  out.sigma = std::sqrt(square / n - out.mean * out.mean);
  out.neighbour = near_sum / near_n / (square / n);
  out.far = far_sum / far_n / (square / n);
  out.holes = holes / (10.0 * kWidth * kHeight);
  return out;
}

DepthNoiseConfig stereo_config() {
  DepthNoiseConfig config;
  config.noise = {NoiseModel::Kind::kStereo, 3'000'000};
  config.metres_per_unit = 0.0001;
  config.max_m = 6.5;
  return config;
}

TEST(DepthNoise, StereoSigmaIsSTimesZSquaredWithin3Percent) {
  for (const double z : {0.7, 1.5, 4.0}) {
    const auto s = measured(stereo_config(), z, [z](double r) { return 1 / r - 1 / z; });
    EXPECT_NEAR(s.sigma, 0.003, 0.03 * 0.003) << z;
    EXPECT_NEAR(s.mean, 0, 0.0001) << z;
    const auto metres = measured(stereo_config(), z, [z](double r) { return r - z; });
    EXPECT_NEAR(metres.sigma, 0.003 * z * z, 0.04 * 0.003 * z * z) << z;
  }
}

TEST(DepthNoise, TimeOfFlightSigmaIsSWithin3Percent) {
  DepthNoiseConfig config;
  config.noise = {NoiseModel::Kind::kTof, 5'000'000};
  for (const double z : {0.7, 4.0, 9.0}) {
    const auto s = measured(config, z, [z](double r) { return r - z; });
    EXPECT_NEAR(s.sigma, 0.005, 0.03 * 0.005) << z;
    EXPECT_NEAR(s.mean, 0, 0.0002) << z;
  }
}

TEST(DepthNoise, NeighboursShareTheConfiguredPartAndDistantPixelsNothing) {
  DepthNoiseConfig config = stereo_config();
  const auto error = [](double r) { return 1 / r - 0.5; };
  const auto half = measured(config, 2.0, error);
  EXPECT_GT(half.neighbour, 0.4);
  EXPECT_LT(half.neighbour, 0.55);
  EXPECT_NEAR(half.far, 0, 0.02);
  config.correlated_share = 0;
  EXPECT_NEAR(measured(config, 2.0, error).neighbour, 0, 0.01);
}

TEST(DepthNoise, DropsHalfAPercentOrWhatIsAsked) {
  DepthNoiseConfig config = stereo_config();
  const auto error = [](double r) { return r; };
  EXPECT_NEAR(measured(config, 2.0, error).holes, 0.005, 0.0005);
  config.dropout = 0.2;
  EXPECT_NEAR(measured(config, 2.0, error).holes, 0.2, 0.005);
  config.dropout = 0;
  EXPECT_EQ(measured(config, 2.0, error).holes, 0);
}

TEST(DepthNoise, ReadingsLieOnTheLatticeRoundedToTheUnit) {
  DepthNoiseConfig config = stereo_config();
  config.metres_per_unit = 0.001;
  config.lattice_c_m = 612.8;
  DepthNoise noise(config, kWidth, kHeight);
  const std::vector<double> truth(kWidth * kHeight, 3.0);
  std::vector<std::uint16_t> counts(truth.size());
  Pcg32 random(1);
  noise.apply(truth, random, counts);
  for (const std::uint16_t count : counts) {
    if (count == 0) continue;
    const double level = std::round(612.8 / (count * 0.001));
    ASSERT_NEAR(612.8 / level, count * 0.001, 0.5001e-3);
  }
}

TEST(DepthNoise, ReadingsOutOfRangeOrOverflowingAreHoles) {
  DepthNoiseConfig config;
  config.min_m = 0.5;
  config.max_m = 100;
  config.dropout = 0;
  DepthNoise noise(config, 6, 1);
  const std::vector<double> truth{0.0, 0.4, 0.6, 65.5, 65.6, 120.0};
  std::vector<std::uint16_t> counts(6);
  Pcg32 random(1);
  noise.apply(truth, random, counts);
  EXPECT_EQ(counts, (std::vector<std::uint16_t>{0, 0, 600, 65500, 0, 0}));
}

// A post 1 m away before a wall at 3 m, f b = 30 px m: the second eye sees the post 30 px and the
// wall 10 px to the left, so that 20 px of wall left of the post are hidden from it.
TEST(DepthNoise, APostCastsItsShadowToTheLeft) {
  DepthNoiseConfig config;
  config.shadow_px_m = 30;
  config.dropout = 0;
  DepthNoise noise(config, 100, 1);
  std::vector<double> truth(100, 3.0);
  for (std::size_t u = 60; u < 90; ++u) truth[u] = 1.0;
  std::vector<std::uint16_t> counts(100);
  Pcg32 random(1);
  noise.apply(truth, random, counts);
  for (std::size_t u = 0; u < 100; ++u) {
    const bool hidden = u >= 40 && u < 60;
    EXPECT_EQ(counts[u] == 0, hidden) << u;
  }
}

}  // namespace
}  // namespace planecast
