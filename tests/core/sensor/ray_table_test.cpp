// The integer ray table against doubles, its refusals, and its frozen bits.
#include "core/sensor/ray_table.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "core/base/random.hpp"
#include "core/sensor/ray_length.hpp"

namespace planecast {
namespace {

constexpr double kQ27 = 134217728.0;

struct Table {
  std::vector<std::int32_t> storage;
  RayTable rays;
  Status status = Status::kOk;
};

Table table_of(const CameraModel& camera) {
  Table out;
  out.storage.resize(ray_table_entries(camera));
  out.status = build_ray_table(camera, out.storage, out.rays);
  return out;
}

CameraModel camera_of(const Intrinsics& in, std::uint32_t width, std::uint32_t height) {
  return *quantise(in, width, height);
}

std::pair<double, double> distort(const Intrinsics& k, double x, double y) {
  const double r2 = x * x + y * y;
  const double radial = 1 + r2 * (k.k1 + r2 * (k.k2 + r2 * k.k3));
  return {x * radial + 2 * k.p1 * x * y + k.p2 * (r2 + 2 * x * x),
          y * radial + k.p1 * (r2 + 2 * y * y) + 2 * k.p2 * x * y};
}

// Newton's method in doubles with a numeric Jacobian.
std::pair<double, double> undistort(const Intrinsics& k, double tx, double ty) {
  double x = tx;
  double y = ty;
  for (int i = 0; i < 60; ++i) {
    const double h = 1e-6;
    const auto [fx, fy] = distort(k, x, y);
    const auto [fxx, fyx] = distort(k, x + h, y);
    const auto [fxy, fyy] = distort(k, x, y + h);
    const double a = (fxx - fx) / h, b = (fxy - fx) / h, c = (fyx - fy) / h, d = (fyy - fy) / h;
    const double det = a * d - b * c;
    x += (d * (tx - fx) - b * (ty - fy)) / det;
    y += (a * (ty - fy) - c * (tx - fx)) / det;
  }
  return {x, y};
}

double worst_against_newton(const CameraModel& camera, const RayTable& rays) {
  const Intrinsics k = to_intrinsics(camera);
  double worst = 0;
  for (std::uint32_t v = 0; v < camera.height; v += 3) {
    for (std::uint32_t u = 0; u < camera.width; u += 3) {
      const auto [x, y] = undistort(k, (u - k.cx) / k.fx, (v - k.cy) / k.fy);
      worst =
          std::max({worst, std::abs(rays.x(u, v) / kQ27 - x), std::abs(rays.y(u, v) / kQ27 - y)});
    }
  }
  return worst;
}

std::uint64_t fnv1a(std::span<const std::int32_t> values) {
  std::uint64_t hash = 14695981039346656037ULL;
  for (const std::int32_t value : values) {
    for (int i = 0; i < 4; ++i) {
      hash ^= (static_cast<std::uint32_t>(value) >> (8 * i)) & 255U;
      hash *= 1099511628211ULL;
    }
  }
  return hash;
}

const Intrinsics kPlain{383.8, 383.8, 321.7, 236.8, 0, 0, 0, 0, 0, 0.001};
const Intrinsics kLens{600.0, 601.0, 325.3, 241.7, -0.28, 0.09, 0.001, -0.0006, -0.01, 0.001};

TEST(RayTable, WithoutDistortionIsTheRoundedPinholeRay) {
  const CameraModel camera = camera_of(kPlain, 640, 480);
  const Table table = table_of(camera);
  ASSERT_EQ(table.status, Status::kOk);
  EXPECT_TRUE(table.rays.separable);
  EXPECT_EQ(table.storage.size(), 640U + 480U);
  const Intrinsics k = to_intrinsics(camera);
  for (std::uint32_t u = 0; u < 640; ++u) {
    EXPECT_NEAR(table.rays.x(u, 7), (u - k.cx) / k.fx * kQ27, 0.5001);
  }
  for (std::uint32_t v = 0; v < 480; ++v) {
    EXPECT_NEAR(table.rays.y(7, v), (v - k.cy) / k.fy * kQ27, 0.5001);
  }
}

TEST(RayTable, UndistortsLikeNewtonInDoublesWithin1e8) {
  const CameraModel camera = camera_of(kLens, 640, 480);
  const Table table = table_of(camera);
  ASSERT_EQ(table.status, Status::kOk);
  EXPECT_FALSE(table.rays.separable);
  EXPECT_EQ(table.storage.size(), 2U * 640U * 480U);
  EXPECT_LT(worst_against_newton(camera, table.rays), 1e-8);
}

TEST(RayTable, UndistortsRandomLensesWithin1e6) {
  Pcg32 random(7);
  int solved = 0;
  for (int i = 0; i < 60; ++i) {
    const std::uint32_t width = 1 + random.below(160);
    const std::uint32_t height = 1 + random.below(120);
    Intrinsics in;
    in.fx = width * (0.5 + random.uniform());
    in.fy = in.fx * (0.95 + 0.1 * random.uniform());
    in.cx = width * (0.3 + 0.4 * random.uniform());
    in.cy = height * (0.3 + 0.4 * random.uniform());
    if (height > 6 * in.fy) continue;
    in.k1 = 0.6 * (random.uniform() - 0.5);
    in.k2 = 0.2 * (random.uniform() - 0.5);
    in.p1 = 0.01 * (random.uniform() - 0.5);
    in.p2 = 0.01 * (random.uniform() - 0.5);
    in.k3 = 0.05 * (random.uniform() - 0.5);
    const CameraModel camera = camera_of(in, width, height);
    const Table table = table_of(camera);
    if (table.status != Status::kOk) continue;  // folds: refused, which the next tests cover
    ++solved;
    EXPECT_LT(worst_against_newton(camera, table.rays), 1e-6) << "lens " << i;
  }
  EXPECT_GT(solved, 30);
}

TEST(RayTable, RefusesALensThatFoldsWithinTheImage) {
  Intrinsics in = kPlain;
  in.k1 = -0.9;  // r (1 - 0.9 r^2) turns back at r = 0.61, the corner lies at r = 1.04
  EXPECT_EQ(table_of(camera_of(in, 640, 480)).status, Status::kFieldRange);
  in.k1 = 100;
  in.k2 = -100;
  EXPECT_EQ(table_of(camera_of(in, 640, 480)).status, Status::kFieldRange);
}

TEST(RayTable, SurvivesAnyCoefficientsFromOutside) {
  Pcg32 random(11);
  int refused = 0;
  for (int i = 0; i < 3000; ++i) {
    CameraModel camera;
    camera.width = static_cast<std::uint16_t>(1 + random.below(8));
    camera.height = static_cast<std::uint16_t>(1 + random.below(8));
    camera.fx_q16 = random.next() >> random.below(32);
    camera.fy_q16 = random.next() >> random.below(32);
    const unsigned small = random.below(30);
    camera.cx_q16 = static_cast<std::int32_t>(random.next()) >> small;
    camera.cy_q16 = static_cast<std::int32_t>(random.next()) >> small;
    for (std::int32_t* k :
         {&camera.k1_q24, &camera.k2_q24, &camera.p1_q24, &camera.p2_q24, &camera.k3_q24}) {
      *k = static_cast<std::int32_t>(random.next()) >> random.below(32);
    }
    camera.unit_pm = 1;
    const Table table = table_of(camera);
    if (table.status != Status::kOk) {
      EXPECT_EQ(table.status, Status::kFieldRange);
      ++refused;
      continue;
    }
    for (std::uint32_t v = 0; v < camera.height; ++v) {
      for (std::uint32_t u = 0; u < camera.width; ++u) {
        EXPECT_LE(std::abs(std::int64_t{table.rays.x(u, v)}), std::int64_t{kMaxRay} << 27);
        EXPECT_LE(std::abs(std::int64_t{table.rays.y(u, v)}), std::int64_t{kMaxRay} << 27);
      }
    }
  }
  EXPECT_GT(refused, 100);
  EXPECT_LT(refused, 2999);
}

TEST(RayTable, RefusesStorageThatIsTooShort) {
  const CameraModel camera = camera_of(kLens, 64, 48);
  std::vector<std::int32_t> storage(ray_table_entries(camera) - 1);
  RayTable rays;
  EXPECT_EQ(build_ray_table(camera, storage, rays), Status::kOutOfArena);
}

// Frozen: both ends of a stream must hold these bits. A change here is a change of the wire format.
TEST(RayTable, BitsAreFrozen) {
  EXPECT_EQ(fnv1a(table_of(camera_of(kPlain, 640, 480)).storage), 0x6AA1C010440EC2DULL);
  EXPECT_EQ(fnv1a(table_of(camera_of(kLens, 640, 480)).storage), 0xED9F205ED869EEE6ULL);
}

TEST(RayLength, IsNeverBelowTheTrueLengthAndLessThan2To15Above) {
  Pcg32 random(3);
  for (int i = 0; i < 100000; ++i) {
    const auto x = static_cast<std::int32_t>(random.next()) >> (1 + random.below(20));
    const auto y = static_cast<std::int32_t>(random.next()) >> (1 + random.below(20));
    const long double truth = std::sqrt(1.0L + (x / static_cast<long double>(kQ27)) * (x / kQ27) +
                                        (y / static_cast<long double>(kQ27)) * (y / kQ27));
    const long double bound = ray_length_q16(x, y) / 65536.0L;
    ASSERT_GE(bound, truth - 1e-15L);
    ASSERT_LT(bound, truth + 0x1p-15L);
  }
  EXPECT_EQ(ray_length_q16(0, 0), 65536U);
  EXPECT_EQ(ray_length_q16(kMaxRay << 27, -(kMaxRay << 27)), 744346U);  // sqrt(129) rounded up
}

TEST(RayLength, SquareRootRoundsUpExactly) {
  for (std::uint64_t root : {0ULL, 1ULL, 2ULL, 65535ULL, 3000000000ULL}) {
    EXPECT_EQ(sqrt_ceil(root * root), root);
    EXPECT_EQ(sqrt_ceil(root * root + 1), root + 1);
    if (root > 1) {
      EXPECT_EQ(sqrt_ceil(root * root - 1), root);
    }
  }
}

}  // namespace
}  // namespace planecast
