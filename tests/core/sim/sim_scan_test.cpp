// The scanning laser: points lie on the scene's surfaces, within its noise, without a grid.
#include "core/sim/sim_scan.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace planecast {
namespace {

PointCloud scan_of(const ScanConfig& config, std::uint64_t frame, Pose& pose) {
  auto simulator = ScanSimulator::create(config);
  EXPECT_TRUE(simulator.ok()) << simulator.error().message;
  PointCloud cloud;
  simulator->render(frame, cloud, pose);
  return cloud;
}

ScanConfig small() {
  ScanConfig config;
  config.turns = 180;
  config.beams = 60;
  return config;
}

// The room is 6 x 5 x 2.6 m; its corner is the world's zero.
TEST(ScanSimulator, WithoutNoiseEveryPointLiesInTheRoomAndWallsAreFlat) {
  ScanConfig config = small();
  config.noise = {};
  Pose pose;
  const PointCloud cloud = scan_of(config, 3, pose);
  std::size_t floor = 0, wall = 0;
  for (const Point3f& p : cloud.points) {
    const double x = p.x + pose.tx, y = p.y + pose.ty, z = p.z + pose.tz;
    ASSERT_GT(x, -1e-5);
    ASSERT_LT(x, 6 + 1e-5);
    ASSERT_GT(y, -1e-5);
    ASSERT_LT(y, 5 + 1e-5);
    ASSERT_GT(z, -1e-5);
    ASSERT_LT(z, 2.6 + 1e-5);
    floor += std::abs(z) < 1e-5;
    wall += std::abs(x - 6) < 1e-5;
  }
  EXPECT_GT(floor, cloud.points.size() / 20);
  EXPECT_GT(wall, cloud.points.size() / 50);
}

TEST(ScanSimulator, NoiseLiesAlongTheBeamWithTheDeviationAsked) {
  ScanConfig still = small();
  still.noise = {};
  still.dropout = 0;
  ScanConfig noisy = still;
  noisy.noise = {NoiseModel::Kind::kTof, 10'000'000};
  Pose pose;
  const PointCloud a = scan_of(still, 0, pose), b = scan_of(noisy, 0, pose);
  ASSERT_EQ(a.points.size(), b.points.size());
  double squares = 0, across = 0;
  for (std::size_t i = 0; i < a.points.size(); ++i) {
    const Point3f &p = a.points[i], &q = b.points[i];
    const double range = std::sqrt(double{p.x} * p.x + double{p.y} * p.y + double{p.z} * p.z);
    const double dx = q.x - p.x, dy = q.y - p.y, dz = q.z - p.z;
    const double along = (dx * p.x + dy * p.y + dz * p.z) / range;
    squares += along * along;
    across =
        std::max(across, std::sqrt(std::max(0.0, dx * dx + dy * dy + dz * dz - along * along)));
  }
  EXPECT_NEAR(std::sqrt(squares / static_cast<double>(a.points.size())), 0.01, 0.0005);
  EXPECT_LT(across, 1e-5);
}

TEST(ScanSimulator, ScansAreSeededAndDifferInTheirNumberOfPoints) {
  Pose pose;
  const PointCloud a = scan_of(small(), 0, pose), again = scan_of(small(), 0, pose);
  const PointCloud next = scan_of(small(), 1, pose);
  ASSERT_EQ(a.points.size(), again.points.size());
  EXPECT_TRUE(
      std::equal(a.points.begin(), a.points.end(), again.points.begin(),
                 [](const Point3f& p, const Point3f& q) { return p.x == q.x && p.z == q.z; }));
  EXPECT_NE(a.points.size(), next.points.size());
  EXPECT_FALSE(a.organised());
  EXPECT_EQ(a.width, a.points.size());
  EXPECT_GT(a.points.size(), 180 * 60 * 9 / 10);
}

TEST(ScanSimulator, RefusesWhatCannotTurn) {
  for (const auto spoil :
       {+[](ScanConfig& c) { c.turns = 0; }, +[](ScanConfig& c) { c.beams = 0; },
        +[](ScanConfig& c) { c.beam_reach_rad = 1.6; }, +[](ScanConfig& c) { c.dropout = -1; },
        +[](ScanConfig& c) { c.rate_hz = 0; }}) {
    ScanConfig config;
    spoil(config);
    EXPECT_EQ(ScanSimulator::create(config).error().status, Status::kBadConfig);
  }
}

}  // namespace
}  // namespace planecast
