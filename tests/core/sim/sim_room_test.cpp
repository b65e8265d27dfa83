// The simulator's promises: what it calls the truth is the truth, seeds decide everything, the
// scene has what the issue asks for, and bad sensors are refused.
#include "core/sim/sim_room.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "core/sim/random_scene.hpp"

namespace planecast {
namespace {

struct Frame {
  DepthImage depth;
  std::vector<std::uint16_t> ids;
  Pose pose;
};

Frame rendered(RoomSimulator& simulator, std::uint64_t number) {
  Frame frame;
  simulator.render(number, frame.depth, frame.ids, frame.pose);
  return frame;
}

SimConfig clean(SimConfig config) {
  config.noise = NoiseModel{};
  config.dropout = 0;
  config.shadows = false;
  config.steps_per_pixel = 0;
  config.max_m = 60;
  return config;
}

SimConfig small_default() {
  SimConfig config = default_sim_config();
  config.width = 160;
  config.height = 120;
  config.intrinsics.fx = config.intrinsics.fy = 95.75;
  config.intrinsics.cx = 79.5;
  config.intrinsics.cy = 59.5;
  config.baseline_m *= 4;  // the same disparities in metres as at 640 x 480
  return config;
}

struct Rays {
  std::vector<std::int32_t> storage;
  RayTable table;
};

Rays rays_of(const CameraModel& camera) {
  Rays out;
  out.storage.resize(ray_table_entries(camera));
  EXPECT_EQ(build_ray_table(camera, out.storage, out.table), Status::kOk);
  return out;
}

// Distance of a point from a true surface [m].
double off_surface(const TruthSurface& s, const Vec3& p) {
  switch (s.kind) {
    case TruthSurface::Kind::kPlane:
      return std::abs(dot(s.normal, p) - s.distance);
    case TruthSurface::Kind::kSphere: {
      const Vec3 r = p - s.centre;
      return std::abs(std::sqrt(dot(r, r)) - s.radius);
    }
    case TruthSurface::Kind::kCylinder: {
      const Vec3 r = p - s.centre;
      const Vec3 across = r - dot(r, s.axis) * s.axis;
      return std::abs(std::sqrt(dot(across, across)) - s.radius);
    }
  }
  return 1e9;
}

// Every reading of a noise-free frame lies on its true surface to the rounding of its count.
void expect_truth(RoomSimulator& simulator, std::uint64_t number) {
  const Frame frame = rendered(simulator, number);
  const Rays rays = rays_of(simulator.camera());
  const double unit = simulator.config().intrinsics.metres_per_unit;
  for (std::uint32_t v = 0; v < frame.depth.height; ++v) {
    for (std::uint32_t u = 0; u < frame.depth.width; ++u) {
      const std::size_t i = std::size_t{v} * frame.depth.width + u;
      if (frame.depth.depth[i] == 0) continue;
      ASSERT_GT(frame.ids[i], 0);
      ASSERT_LE(frame.ids[i], simulator.surfaces().size());
      const TruthSurface& surface = simulator.surfaces()[frame.ids[i] - 1U];
      const double z = frame.depth.depth[i] * unit;
      const Vec3 ray{rays.table.x(u, v) * 0x1p-27, rays.table.y(u, v) * 0x1p-27, 1};
      const double rounding = 0.5 * unit * std::sqrt(dot(ray, ray));
      ASSERT_LE(off_surface(surface, z * ray), rounding + 1e-9) << "pixel " << u << "," << v;
      if (surface.kind == TruthSurface::Kind::kPlane) {
        ASSERT_NEAR(z, surface.distance / dot(surface.normal, ray), 0.5 * unit + 1e-9);
      }
    }
  }
}

TEST(SimRoom, NoiseFreeDepthIsTheTruthToRounding) {
  auto simulator = RoomSimulator::create(clean(default_sim_config()));
  ASSERT_TRUE(simulator.ok());
  for (const std::uint64_t number : {0, 250, 700}) expect_truth(*simulator, number);
}

TEST(SimRoom, DistortedSensorsSeeTheSameTruth) {
  SimConfig config = clean(small_default());
  config.intrinsics.k1 = -0.12;
  config.intrinsics.k2 = 0.02;
  config.intrinsics.p1 = 0.001;
  config.intrinsics.p2 = -0.002;
  auto simulator = RoomSimulator::create(config);
  ASSERT_TRUE(simulator.ok()) << simulator.error().message;
  expect_truth(*simulator, 3);
  // The lens model, forward and in doubles, brings every true point back to its pixel.
  const Intrinsics k = to_intrinsics(simulator->camera());
  const Rays rays = rays_of(simulator->camera());
  for (std::uint32_t v = 0; v < 120; v += 7) {
    for (std::uint32_t u = 0; u < 160; u += 7) {
      const double x = rays.table.x(u, v) * 0x1p-27;
      const double y = rays.table.y(u, v) * 0x1p-27;
      const double r2 = x * x + y * y;
      const double radial = 1 + r2 * (k.k1 + r2 * k.k2);
      const double xd = x * radial + 2 * k.p1 * x * y + k.p2 * (r2 + 2 * x * x);
      const double yd = y * radial + k.p1 * (r2 + 2 * y * y) + 2 * k.p2 * x * y;
      EXPECT_NEAR(k.fx * xd + k.cx, u, 1e-4);
      EXPECT_NEAR(k.fy * yd + k.cy, v, 1e-4);
    }
  }
}

TEST(SimRoom, RandomScenesTellTheTruthToo) {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    SCOPED_TRACE(seed);
    RandomScene random = random_scene(seed);
    auto simulator = RoomSimulator::create(clean(random.config), random.scene);
    ASSERT_TRUE(simulator.ok()) << simulator.error().message;
    expect_truth(*simulator, 5);
  }
}

TEST(SimRoom, SurfacesStayPutInTheWorldWhileTheCameraMoves) {
  auto simulator = RoomSimulator::create(clean(small_default()));
  ASSERT_TRUE(simulator.ok());
  const Frame first = rendered(*simulator, 0);
  const std::vector<TruthSurface> before(simulator->surfaces().begin(),
                                         simulator->surfaces().end());
  const Frame later = rendered(*simulator, 90);
  ASSERT_EQ(before.size(), simulator->surfaces().size());
  for (std::size_t i = 0; i < before.size(); ++i) {
    const TruthSurface& now = simulator->surfaces()[i];
    ASSERT_EQ(now.kind, before[i].kind);
    auto world_centre = [](const TruthSurface& s, const Pose& p) {
      return Vec3{p.tx, p.ty, p.tz} + rotation_of(p).apply(s.centre);
    };
    if (now.kind == TruthSurface::Kind::kPlane) {
      const Vec3 a = rotation_of(first.pose).apply(before[i].normal);
      const Vec3 b = rotation_of(later.pose).apply(now.normal);
      EXPECT_NEAR(std::abs(dot(a, b)), 1, 1e-9);
      const double da = before[i].distance + dot(a, {first.pose.tx, first.pose.ty, first.pose.tz});
      const double db = now.distance + dot(b, {later.pose.tx, later.pose.ty, later.pose.tz});
      EXPECT_NEAR(da, dot(a, b) * db, 1e-9);
    } else {
      const Vec3 gap = world_centre(before[i], first.pose) - world_centre(now, later.pose);
      EXPECT_NEAR(dot(gap, gap), 0, 1e-18);
    }
  }
}

TEST(SimRoom, ASeedDecidesEveryPixelInAnyOrderOfFrames) {
  auto one = RoomSimulator::create(small_default());
  auto two = RoomSimulator::create(small_default());
  ASSERT_TRUE(one.ok() && two.ok());
  const Frame a0 = rendered(*one, 0);
  const Frame a9 = rendered(*one, 9);
  const Frame b9 = rendered(*two, 9);
  const Frame b0 = rendered(*two, 0);
  EXPECT_EQ(a0.depth.depth, b0.depth.depth);
  EXPECT_EQ(a9.depth.depth, b9.depth.depth);
  EXPECT_EQ(a9.ids, b9.ids);
  EXPECT_NE(a0.depth.depth, a9.depth.depth);
  SimConfig other = small_default();
  other.seed = 2;
  auto three = RoomSimulator::create(other);
  ASSERT_TRUE(three.ok());
  EXPECT_NE(rendered(*three, 0).depth.depth, a0.depth.depth);
  EXPECT_EQ(rendered(*three, 0).ids, a0.ids);
}

TEST(SimRoom, ARoundShowsFloorWallsStairsFurnitureSphereAndCylinder) {
  auto simulator = RoomSimulator::create(clean(small_default()));
  ASSERT_TRUE(simulator.ok());
  std::map<std::uint16_t, std::size_t> pixels;
  std::set<TruthSurface::Kind> kinds;
  for (std::uint64_t number = 0; number < 1200; number += 40) {
    for (const std::uint16_t id : rendered(*simulator, number).ids) ++pixels[id];
  }
  EXPECT_EQ(pixels.count(0), 0U) << "a closed room has no pixel without surface";
  for (std::uint16_t wall = 1; wall <= 6; ++wall) EXPECT_GT(pixels[wall], 300U) << wall;
  for (std::uint16_t step = 0; step < 4; ++step) {
    EXPECT_GT(pixels[static_cast<std::uint16_t>(7 + 6 * step)], 50U) << "riser " << step;
    EXPECT_GT(pixels[static_cast<std::uint16_t>(7 + 6 * step + 5)], 50U) << "tread " << step;
  }
  std::size_t seen = 0;
  for (const auto& [id, count] : pixels) {
    if (count < 50) continue;
    ++seen;
    kinds.insert(simulator->surfaces()[id - 1U].kind);
  }
  EXPECT_GT(seen, 50U);
  EXPECT_EQ(kinds.size(), 3U);
}

TEST(SimRoom, TheCameraMovesSmoothlyAndKeepsItsDistance) {
  SimConfig config = clean(small_default());
  config.width = 16;
  config.height = 12;
  config.intrinsics.fx = config.intrinsics.fy = 9.6;
  config.intrinsics.cx = 7.5;
  config.intrinsics.cy = 5.5;
  auto simulator = RoomSimulator::create(config);
  ASSERT_TRUE(simulator.ok());
  Pose last = rendered(*simulator, 0).pose;
  double travelled = 0;
  for (std::uint64_t number = 1; number < 2400; ++number) {
    const Pose pose = rendered(*simulator, number).pose;
    const double step = std::hypot(pose.tx - last.tx, pose.ty - last.ty, pose.tz - last.tz);
    const double cosine =
        std::abs(pose.qw * last.qw + pose.qx * last.qx + pose.qy * last.qy + pose.qz * last.qz);
    ASSERT_LT(step, 0.03);
    ASSERT_LT(2 * std::acos(std::min(1.0, cosine)), 0.02);
    const auto z = simulator->true_depth_m();
    ASSERT_GT(*std::min_element(z.begin(), z.end()), 0.25) << "frame " << number;
    travelled += step;
    last = pose;
  }
  EXPECT_GT(travelled, 5);
  config.moving = false;
  auto still = RoomSimulator::create(config);
  ASSERT_TRUE(still.ok());
  EXPECT_EQ(rendered(*still, 0).pose.tx, rendered(*still, 500).pose.tx);
}

TEST(SimRoom, EveryPresetRenders) {
  for (const SensorPreset& preset : sensor_presets()) {
    SCOPED_TRACE(std::string(preset.name));
    auto simulator = RoomSimulator::create(sim_config(preset));
    ASSERT_TRUE(simulator.ok());
    const Frame frame = rendered(*simulator, 0);
    ASSERT_EQ(frame.depth.depth.size(), std::size_t{preset.width} * preset.height);
    const auto holes = std::count(frame.depth.depth.begin(), frame.depth.depth.end(), 0);
    EXPECT_LT(static_cast<double>(holes), 0.5 * static_cast<double>(frame.depth.depth.size()));
  }
}

TEST(SimRoom, RefusesSensorsThatCannotBe) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  auto refused = [](auto change) {
    SimConfig config = default_sim_config();
    change(config);
    const auto simulator = RoomSimulator::create(config);
    return !simulator.ok() && simulator.error().status == Status::kBadConfig &&
           !simulator.error().message.empty();
  };
  EXPECT_TRUE(refused([](SimConfig& c) { c.intrinsics.fx = 0; }));
  EXPECT_TRUE(refused([](SimConfig& c) { c.width = 0; }));
  EXPECT_TRUE(refused([](SimConfig& c) { c.rate_hz = 0; }));
  EXPECT_TRUE(refused([](SimConfig& c) { c.dropout = 1.5; }));
  EXPECT_TRUE(refused([&](SimConfig& c) { c.dropout = nan; }));
  EXPECT_TRUE(refused([](SimConfig& c) { c.correlated_share = -0.1; }));
  EXPECT_TRUE(refused([](SimConfig& c) { c.baseline_m = -1; }));
  EXPECT_TRUE(refused([](SimConfig& c) { c.intrinsics.k1 = -2; }));
}

TEST(RandomScene, CoversSizesSensorsAndLenses) {
  std::set<NoiseModel::Kind> kinds;
  int distorted = 0, tiny = 0, large = 0, lattice = 0, moving = 0;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    const RandomScene scene = random_scene(seed);
    EXPECT_TRUE(RoomSimulator::create(scene.config, scene.scene).ok()) << seed;
    kinds.insert(scene.config.noise.kind);
    distorted += scene.config.intrinsics.k1 != 0;
    tiny += scene.config.width * scene.config.height <= 64;
    large += scene.config.width * scene.config.height > 100000;
    lattice += scene.config.steps_per_pixel > 0;
    moving += scene.scene.path.period_s > 0;
    EXPECT_LE(scene.config.width, 640U);
    EXPECT_LE(scene.config.height, 480U);
  }
  EXPECT_EQ(kinds.size(), 3U);
  for (const int share : {distorted, tiny, large, lattice, moving}) {
    EXPECT_GT(share, 10);
    EXPECT_LT(share, 390);
  }
}

}  // namespace
}  // namespace planecast
