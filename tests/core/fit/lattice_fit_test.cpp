// The lattice is found where a sensor has one, to the last level, and nowhere else.
#include "core/fit/lattice_fit.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/io/depth_png.hpp"
#include "core/io/pcd.hpp"
#include "core/predict/level_table.hpp"
#include "core/sim/sim_room.hpp"
#include "tests/support/data_path.hpp"

namespace planecast {
namespace {

std::vector<std::uint16_t> simulated(const SimConfig& config) {
  Result<RoomSimulator> simulator = RoomSimulator::create(config);
  EXPECT_TRUE(simulator.ok());
  DepthImage depth;
  std::vector<std::uint16_t> truth;
  Pose pose;
  simulator->render(0, depth, truth, pose);
  return depth.depth;
}

TEST(LatticeFit, FindsTheSimulatorsLatticeAndExplainsItsReadings) {
  const SimConfig config = default_sim_config();
  ASSERT_GT(config.steps_per_pixel, 0);
  const auto lattice = find_lattice(simulated(config));
  ASSERT_TRUE(lattice.has_value());
  const double c = config.intrinsics.fx * config.baseline_m * config.steps_per_pixel /
                   config.intrinsics.metres_per_unit;
  EXPECT_NEAR(lattice->c_q8 / 256.0, c, c * 1e-3);
}

TEST(LatticeFit, FindsNoneInTimeOfFlightOrTooFewCounts) {
  SimConfig config = default_sim_config();
  config.baseline_m = 0;
  config.steps_per_pixel = 0;
  config.noise = {NoiseModel::Kind::kTof, 5'000'000};
  EXPECT_FALSE(find_lattice(simulated(config)).has_value());
  EXPECT_FALSE(find_lattice(std::vector<std::uint16_t>(100, 0)).has_value());
  EXPECT_FALSE(find_lattice(std::vector<std::uint16_t>(100, 1000)).has_value());
}

TEST(LatticeFit, FindsTheLatticeOfARealSenseFrame) {
  PLANECAST_NEED_DATA(path, "depth_seq/aims_realsense/0.png");
  const auto image = read_depth_png(path);
  ASSERT_TRUE(image.ok());
  const auto lattice = find_lattice(image->depth);
  ASSERT_TRUE(lattice.has_value());
  EXPECT_NEAR(lattice->c_q8 / 256.0, 612357.75, 20);
  EXPECT_EQ(lattice->offset_q16, 0U);
  EXPECT_FALSE(lattice->truncated);
}

TEST(LatticeFit, FindsTheOffsetAndCutOfAKinectFrame) {
  PLANECAST_NEED_DATA(path, "depth_frames/pcl_misc/office1.pcd");
  const auto cloud = read_pcd(path);
  ASSERT_TRUE(cloud.ok());
  std::vector<std::uint16_t> depth;
  for (const Point3f& p : cloud->points) {
    depth.push_back(std::isnan(p.z) ? std::uint16_t{0}
                                    : static_cast<std::uint16_t>(std::lround(p.z * 1000.0F)));
  }
  const auto lattice = find_lattice(depth);
  ASSERT_TRUE(lattice.has_value());
  EXPECT_NEAR(lattice->c_q8 / 256.0, 345493.6, 50);
  EXPECT_NEAR(lattice->offset_q16 / 65536.0, 0.409, 0.01);
  EXPECT_TRUE(lattice->truncated);
}

TEST(LatticeFit, FindsNoneInARealTimeOfFlightFrame) {
  PLANECAST_NEED_DATA(path, "depth_frames/stair_kinect2/0000_depth.png");
  const auto image = read_depth_png(path);
  ASSERT_TRUE(image.ok());
  EXPECT_FALSE(find_lattice(image->depth).has_value());
}

}  // namespace
}  // namespace planecast
