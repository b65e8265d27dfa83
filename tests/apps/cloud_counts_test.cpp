// Counts of four points at a time against those of one by one, over cameras, axes, grids, ranges.
#include "apps/common/cloud_counts.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "tests/core/model/random_config.hpp"

namespace planecast {
namespace {

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinite = std::numeric_limits<float>::infinity();
constexpr std::uint32_t kCloudHeight = 5;

// A stream of clouds with a bound of some millimetres or sigmas, its camera in turned axes or not.
StreamSetup random_setup(Pcg32& random, std::uint32_t width, bool lossless, bool turned) {
  StreamSetup setup;
  setup.cloud_input = true;
  StreamConfig& config = setup.encoder.stream;
  config.camera = test::random_camera(random, width, kCloudHeight, 1.5, true);
  config.camera.unit_pm = 500'000'000;
  config.tolerance = lossless ? ToleranceKind::kLossless : ToleranceKind::kMetres;
  if (turned) {
    Pose pose;
    pose.qx = test::between(random, -1, 1);
    pose.qy = test::between(random, -1, 1);
    pose.tx = test::between(random, -2, 2);
    EXPECT_EQ(to_fixed(pose, config.axes), Status::kOk);
    config.mirror_y = random.below(2) == 0;
  }
  setup.contract.kind = lossless               ? ToleranceKind::kLossless
                        : random.below(2) == 0 ? ToleranceKind::kSigma
                                               : ToleranceKind::kMetres;
  setup.contract.noise = {NoiseModel::Kind::kStereo, 3'000'000};
  setup.contract.value = setup.contract.kind == ToleranceKind::kMetres ? 0.008 : 2;
  setup.allowed_share = 0.25;
  setup.rays = *camera_rays(config.camera);
  return setup;
}

void use_grid(StreamSetup& setup, ZGrid::Rule rule) {
  setup.encoder.stream.z_rule = static_cast<ZRule>(rule);
  setup.grid = std::make_shared<const ZGridTable>(ZGrid{setup.encoder.stream.camera.unit_pm, rule});
}

struct Scene {
  SensorFrame frame;
  std::vector<std::uint16_t> counts;
};

double allowance_m(const StreamSetup& setup, double depth) {
  if (setup.encoder.stream.tolerance == ToleranceKind::kLossless) return kExactResidual_m;
  return setup.allowed_share * setup.contract.bound_m(depth);
}

// The point of a count, `off` of what it may lie off it away from its own place.
Point3f point_at(const StreamSetup& setup, std::uint32_t u, std::uint32_t v, std::uint16_t count,
                 double off, Pcg32& random) {
  const RayTable& rays = setup.rays->table;
  const double unit = static_cast<double>(setup.encoder.stream.camera.unit_pm) * 1e-12;
  const OpticalAxes axes(setup.encoder.stream);
  const auto p = axes.point(rays.x(u, v) * kRayUnit, rays.y(u, v) * kRayUnit, count * unit);
  double to[3], length = 0;
  for (double& t : to) t = test::between(random, -1, 1);
  if (setup.grid != nullptr) to[2] = 0;
  for (const double t : to) length += t * t;
  const double step = off * allowance_m(setup, count * unit) / std::sqrt(length);
  Point3f out{static_cast<float>(p.x + to[0] * step), static_cast<float>(p.y + to[1] * step),
              static_cast<float>(p.z + to[2] * step)};
  if (setup.grid != nullptr) out.z = setup.grid->z(count);
  return out;
}

Scene random_scene(const StreamSetup& setup, Pcg32& random) {
  const CameraModel& camera = setup.encoder.stream.camera;
  Scene out;
  out.frame.name = "scene";
  out.frame.cloud.width = camera.width;
  out.frame.cloud.height = camera.height;
  const std::vector<Point3f> holes{
      {kNone, kNone, kNone}, {0, 0, 0}, {1, kNone, 2}, {kInfinite, 1, 1}, {1, -kInfinite, 1}};
  for (std::uint32_t v = 0; v < camera.height; ++v) {
    for (std::uint32_t u = 0; u < camera.width; ++u) {
      const bool hole = random.below(4) == 0;
      const auto count = static_cast<std::uint16_t>(1200 + random.below(12'000));
      out.counts.push_back(hole ? 0 : count);
      out.frame.cloud.points.push_back(hole ? holes[random.below(5)]
                                            : point_at(setup, u, v, count, 0.1, random));
    }
  }
  return out;
}

std::uint32_t distance(std::uint16_t a, std::uint16_t b) {
  return a > b ? a - b : b - a;
}

TEST(CloudCounts, EveryPointGetsTheCountItLiesAtAndHolesNone) {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    Pcg32 random(seed);
    const bool turned = seed % 3 == 0;
    StreamSetup setup = random_setup(random, 1 + random.below(40), false, turned);
    if (!turned && seed % 2 == 0) use_grid(setup, static_cast<ZGrid::Rule>(random.below(3)));
    const Scene scene = random_scene(setup, random);
    std::vector<std::uint16_t> depth;
    const auto done = count_cloud(setup, scene.frame, Proof::kMisfit, depth);
    ASSERT_TRUE(done.ok()) << seed << ": " << done.error().message;
    ASSERT_EQ(depth.size(), scene.counts.size());
    for (std::size_t i = 0; i < depth.size(); ++i) {
      const double apart_m = distance(depth[i], scene.counts[i]) * 0.0005;
      const double moved_m = 0.1 * allowance_m(setup, scene.counts[i] * 0.0005);
      const bool exact = setup.grid != nullptr || scene.counts[i] == 0;
      ASSERT_LE(apart_m, exact ? 0 : moved_m + 0.0005) << seed << ", " << i;
    }
  }
}

TEST(CloudCounts, OnePointOffTheRaysIsNamedWhereverItLies) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    Pcg32 random(seed);
    const std::uint32_t width = 5 + random.below(12);
    StreamSetup setup = random_setup(random, width, seed % 4 == 1, seed % 2 == 0);
    if (seed % 4 == 1) use_grid(setup, ZGrid::Rule::kDoubleProduct);
    const Scene scene = random_scene(setup, random);
    for (std::uint32_t u = 0; u < width; ++u) {
      SensorFrame frame = scene.frame;
      const std::uint32_t v = random.below(kCloudHeight);
      Point3f& point = frame.cloud.points[v * width + u];
      point = point_at(setup, (u + 2) % width, v, 6000, 0, random);
      std::vector<std::uint16_t> depth;
      const auto done = count_cloud(setup, frame, Proof::kMisfit, depth);
      ASSERT_FALSE(done.ok()) << seed << ", column " << u;
      EXPECT_EQ(done.error().status, Status::kBoundExceeded);
      const std::string place = "(column " + std::to_string(u) + ", row " + std::to_string(v) + ")";
      EXPECT_NE(done.error().message.find(place), std::string::npos) << done.error().message;
      EXPECT_TRUE(count_cloud(setup, frame, Proof::kNone, depth).ok()) << seed << ", " << u;
    }
  }
}

TEST(CloudCounts, ABoundIsKeptToAThousandth) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    Pcg32 random(seed);
    StreamSetup setup = random_setup(random, 9, false, false);
    use_grid(setup, ZGrid::Rule::kDoubleProduct);
    Scene scene = random_scene(setup, random);
    const std::uint32_t u = random.below(9);
    std::vector<std::uint16_t> depth;
    scene.frame.cloud.points[u] = point_at(setup, u, 0, 6000, 0.999, random);
    EXPECT_TRUE(count_cloud(setup, scene.frame, Proof::kMisfit, depth).ok()) << seed;
    scene.frame.cloud.points[u] = point_at(setup, u, 0, 6000, 1.001, random);
    EXPECT_FALSE(count_cloud(setup, scene.frame, Proof::kMisfit, depth).ok()) << seed;
  }
}

TEST(CloudCounts, APointWithoutACountIsNamedWithAndWithoutProof) {
  Pcg32 random(1);
  StreamSetup setup = random_setup(random, 10, false, false);
  use_grid(setup, ZGrid::Rule::kFloatProduct);
  Scene scene = random_scene(setup, random);
  Point3f& point = scene.frame.cloud.points[23];
  std::vector<std::uint16_t> depth;
  for (const float z : {std::nextafter(setup.grid->z(3000), 10.0F), 0.0F, -1.0F, 40.0F, 1e30F}) {
    point = {0.1F, 0.1F, z};
    for (const Proof proof : {Proof::kNone, Proof::kMisfit}) {
      const auto done = count_cloud(setup, scene.frame, proof, depth);
      ASSERT_FALSE(done.ok()) << z;
      EXPECT_NE(done.error().message.find("(column 3, row 2)"), std::string::npos)
          << done.error().message;
    }
  }
}

TEST(CloudCounts, ReadingsOutOfRangeGetCountsThatTheGateRefusesWhereverTheyLie) {
  Pcg32 random(1);
  StreamSetup setup = random_setup(random, 8, false, false);
  use_grid(setup, ZGrid::Rule::kDoubleProduct);
  setup.encoder.stages.range_min = 1000;
  setup.encoder.stages.range_max = 14'000;
  Scene scene = random_scene(setup, random);
  const float depths[] = {0.1F, -3.0F, 7.2F, 1e20F};  // none on its ray, two on no count
  for (std::size_t i = 0; i < 4; ++i) scene.frame.cloud.points[3 + i] = {5, 5, depths[i]};
  std::vector<std::uint16_t> depth;
  ASSERT_TRUE(count_cloud(setup, scene.frame, Proof::kMisfit, depth).ok());
  EXPECT_EQ(depth[3], 1);
  EXPECT_EQ(depth[4], 1);
  EXPECT_EQ(depth[5], 65535);
  EXPECT_EQ(depth[6], 65535);
}

}  // namespace
}  // namespace planecast
