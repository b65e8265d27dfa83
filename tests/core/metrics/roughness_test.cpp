// The noise found in a cloud is the noise that was put into it.
#include "core/metrics/roughness.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace planecast {
namespace {

std::vector<Point3f> noisy_plane(double sigma_m) {
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0, sigma_m);
  std::uniform_real_distribution<double> place(-1, 1);
  std::vector<Point3f> out;
  for (int i = 0; i < 20'000; ++i) {
    const double x = place(random), y = place(random);
    out.push_back({static_cast<float>(x), static_cast<float>(y),
                   static_cast<float>(2 + 0.3 * x - 0.2 * y + noise(random))});
  }
  return out;
}

TEST(Roughness, FindsTheNoiseOfAPlaneWithinAFifth) {
  for (const double sigma : {0.001, 0.004}) {
    const double across = sigma / std::sqrt(1 + 0.3 * 0.3 + 0.2 * 0.2);
    EXPECT_NEAR(surface_roughness_m(noisy_plane(sigma)), across, 0.2 * across) << sigma;
  }
}

TEST(Roughness, IsNothingForAPlaneAndForTooFewPoints) {
  EXPECT_LT(surface_roughness_m(noisy_plane(0)), 1e-6);
  EXPECT_EQ(surface_roughness_m({}), 0);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<Point3f> few = {{0, 0, 0}, {1, 0, 0}, {nan, nan, nan}, {0, 1, 0}};
  EXPECT_EQ(surface_roughness_m(few), 0);
}

}  // namespace
}  // namespace planecast
