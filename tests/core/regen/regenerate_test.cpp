// Regenerated points against a straightforward computation in double, for every z rule and axes.
#include "core/regen/regenerate.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "tests/core/model/random_config.hpp"

namespace planecast {
namespace {

struct Bench {
  StreamConfig config;
  std::vector<std::int32_t> storage;
  RayTable rays;
  Arena arena = std::move(*Arena::map(std::size_t{1} << 20U));
  DepthScale scale;
  std::vector<std::uint16_t> depth;
  std::vector<Point3f> cloud;

  explicit Bench(const StreamConfig& c) : config(c) {
    storage.resize(ray_table_entries(c.camera));
    EXPECT_EQ(build_ray_table(c.camera, storage, rays), Status::kOk);
    scale.layout(arena);
    scale.build(config);
    depth.resize(c.camera.pixels());
    cloud.resize(c.camera.pixels());
  }
  Status run() { return regenerate(config, rays, scale, depth, cloud); }
};

std::uint32_t bits(float f) {
  return std::bit_cast<std::uint32_t>(f);
}

StreamConfig optical_config(Pcg32& random) {
  StreamConfig c;
  c.camera = test::random_camera(random, 40, 30, 1.5, true);
  c.z_rule = static_cast<ZRule>(random.below(3));
  return c;
}

// z as the rule's words have it, by the C library.
float z_by_words(const StreamConfig& c, std::uint32_t count) {
  const double unit = static_cast<double>(c.camera.unit_pm) / 1e12;
  if (c.z_rule == ZRule::kProductInDouble) return static_cast<float>(count * unit);
  const float product = static_cast<float>(count) * static_cast<float>(unit);
  if (c.z_rule == ZRule::kProductInFloat) return product;
  char text[64];
  std::snprintf(text, sizeof text, "%.7g", static_cast<double>(product));
  return std::strtof(text, nullptr);
}

TEST(Regenerate, EveryZIsWhatTheRuleSaysToTheBit) {
  for (const std::uint64_t unit : {1'000'000'000ULL, 500'000'000ULL, 250'000'000ULL, 200'000'000ULL,
                                   125'000'000ULL, 100'000'000ULL}) {
    for (const ZRule rule : {ZRule::kProductInDouble, ZRule::kProductInFloat, ZRule::kPrinted7}) {
      Pcg32 random(1);
      StreamConfig c = optical_config(random);
      c.camera.unit_pm = unit;
      c.z_rule = rule;
      const Bench b(c);
      for (std::uint32_t d = 1; d < 65536; ++d) {
        ASSERT_EQ(bits(b.scale.z(static_cast<std::uint16_t>(d))), bits(z_by_words(c, d)))
            << unit << " rule " << static_cast<int>(rule) << " count " << d;
      }
    }
  }
}

TEST(Regenerate, PointsOfOpticalAxesLieOnTheirRaysToTheBit) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Pcg32 random(seed);
    Bench b(optical_config(random));
    for (auto& d : b.depth) d = static_cast<std::uint16_t>(random.next());
    ASSERT_EQ(b.run(), Status::kOk);
    std::size_t i = 0;
    for (std::uint32_t v = 0; v < b.rays.height; ++v) {
      for (std::uint32_t u = 0; u < b.rays.width; ++u, ++i) {
        if (b.depth[i] == 0) continue;
        const double z = b.scale.z(b.depth[i]);
        const double x = b.rays.x(u, v) / 134217728.0 * z, y = b.rays.y(u, v) / 134217728.0 * z;
        ASSERT_EQ(bits(b.cloud[i].x), bits(static_cast<float>(x)));
        ASSERT_EQ(bits(b.cloud[i].y), bits(static_cast<float>(y)));
        ASSERT_EQ(bits(b.cloud[i].z), bits(static_cast<float>(z)));
      }
    }
  }
}

TEST(Regenerate, OtherAxesTurnAndShiftThePoints) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Pcg32 random(seed);
    StreamConfig c = optical_config(random);
    Pose pose{0.5, -0.5, 0.1, 0.7, 1.25, -3.5, 0.75};
    pose.qx = test::between(random, -1, 1);
    ASSERT_EQ(to_fixed(pose, c.axes), Status::kOk);
    c.mirror_y = seed % 2 == 1;
    c.camera.unit_pm = 1'000'000'000;
    Bench b(c);
    for (auto& d : b.depth) d = static_cast<std::uint16_t>(random.below(9000));
    ASSERT_EQ(b.run(), Status::kOk);
    const Pose a = to_pose(c.axes);
    std::size_t i = 0;
    for (std::uint32_t v = 0; v < b.rays.height; ++v) {
      for (std::uint32_t u = 0; u < b.rays.width; ++u, ++i) {
        if (b.depth[i] == 0) continue;
        const double z = b.scale.z(b.depth[i]);
        const double p[3] = {b.rays.x(u, v) * 0x1p-27 * z,
                             (c.mirror_y ? -1 : 1) * (b.rays.y(u, v) * 0x1p-27 * z), z};
        // q (0, p) q*: Rodrigues' form, by another road than the matrix.
        const double q[3] = {a.qx, a.qy, a.qz};
        const double t[3] = {2 * (q[1] * p[2] - q[2] * p[1]), 2 * (q[2] * p[0] - q[0] * p[2]),
                             2 * (q[0] * p[1] - q[1] * p[0])};
        const double r[3] = {p[0] + a.qw * t[0] + q[1] * t[2] - q[2] * t[1] + a.tx,
                             p[1] + a.qw * t[1] + q[2] * t[0] - q[0] * t[2] + a.ty,
                             p[2] + a.qw * t[2] + q[0] * t[1] - q[1] * t[0] + a.tz};
        // Half a float's last place of 30 m, and the unit norm's 2^-28.
        ASSERT_NEAR(b.cloud[i].x, r[0], 1.2e-6);
        ASSERT_NEAR(b.cloud[i].y, r[1], 1.2e-6);
        ASSERT_NEAR(b.cloud[i].z, r[2], 1.2e-6);
      }
    }
  }
}

TEST(Regenerate, HolesAreTheOneNaNInAllCoordinatesWhateverTheAxes) {
  Pcg32 random(5);
  StreamConfig c = optical_config(random);
  for (int axes = 0; axes < 3; ++axes) {
    if (axes > 0) c.axes = test::random_pose(random);
    c.mirror_y = axes == 2;
    Bench b(c);
    ASSERT_EQ(b.run(), Status::kOk);
    for (const Point3f& p : b.cloud) {
      ASSERT_EQ(bits(p.x), 0x7fc00000U);
      ASSERT_EQ(bits(p.y), 0x7fc00000U);
      ASSERT_EQ(bits(p.z), 0x7fc00000U);
    }
  }
}

TEST(Regenerate, SpansThatAreTooShortAreRefused) {
  Pcg32 random(6);
  Bench b(optical_config(random));
  const auto pixels = b.depth.size();
  EXPECT_EQ(regenerate(b.config, b.rays, b.scale, std::span(b.depth).first(pixels - 1), b.cloud),
            Status::kWrongSize);
  EXPECT_EQ(regenerate(b.config, b.rays, b.scale, b.depth, std::span(b.cloud).first(pixels - 1)),
            Status::kWrongSize);
}

}  // namespace
}  // namespace planecast
