// Surfaces found in the simulator's room against the truth, at the figures the product states. The
// sensor, the scene and its noise are fixed; these seeds and frames were not looked at while the
// thresholds of segmentation were chosen (those were 1 to 8 and 101 to 132).
#include "tests/system/surfaces/room_quality.hpp"

#include <gtest/gtest.h>

#include "core/sensor/sensor_preset.hpp"
#include "tests/support/sanitized.hpp"

namespace planecast {
namespace {

using namespace test;

constexpr int kSeeds = 16, kFrames = 2;

RoomQuality quality(const char* preset, std::uint64_t first_seed) {
  RoomQuality sum;
  SimConfig sim = sim_config(*find_preset(preset));
  sim.dropout = 0.005;
  for (int i = 0; i < kSeeds; ++i) {
    sim.seed = first_seed + static_cast<std::uint64_t>(i);
    score_room(sim, sim.seed * 37 % 1200, 211, kFrames, 0, sum);
  }
  std::printf(
      "%s, seeds from %d: ratio %.3f %%, points out %.4f, precision %.3f, recall %.3f, of %.0f "
      "planes; least squares with the truth's labels finds %.3f; coefficients within 3 sigma %.4f, "
      "%.1f surfaces a frame\n",
      preset, static_cast<int>(first_seed), sum.ratio_percent(), sum.out_share(), sum.precision(),
      sum.recall(), sum.truth, sum.ceiling(), sum.within_share(), sum.surfaces / sum.frames);
  return sum;
}

class RoomQualityOf : public ::testing::TestWithParam<std::uint64_t> {};

TEST_P(RoomQualityOf, PlanesOfATimeOfFlightCameraAreFound) {
  if (kSanitized) GTEST_SKIP() << "figures do not depend on a sanitizer";
  const RoomQuality sum = quality("azure-nfov", GetParam());
  EXPECT_GE(sum.ratio_percent(), 99.84);
  EXPECT_GE(sum.out_share(), 0.95);
  EXPECT_GE(sum.precision(), 0.95);
  EXPECT_GE(sum.recall(), 0.95);
  EXPECT_GE(sum.within_share(), 0.99);
}

TEST_P(RoomQualityOf, PlanesOfAStereoCameraAreFound) {
  if (kSanitized) GTEST_SKIP() << "figures do not depend on a sanitizer";
  const RoomQuality sum = quality("realsense-d435", GetParam());
  // The noise of a far wall spans what stands before it.
  EXPECT_GE(sum.ratio_percent(), 99.80);
  EXPECT_GE(sum.out_share(), 0.95);
  EXPECT_GE(sum.precision(), 0.65);
  EXPECT_GE(sum.recall(), 0.58);
  EXPECT_GE(sum.within_share(), 0.98);
}

INSTANTIATE_TEST_SUITE_P(Seeds, RoomQualityOf, ::testing::Values(2001, 3001));

}  // namespace
}  // namespace planecast
