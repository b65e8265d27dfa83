// The bound in counts against the bound in metres, point by point, in double arithmetic.
#include "core/predict/bound_table.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/core/model/random_config.hpp"
#include "tests/core/predict/bound_oracle.hpp"
#include "tests/core/predict/predict_bench.hpp"
#include "tests/support/sanitized.hpp"

namespace planecast {
namespace {

using test::bound_m;
using test::distance;
using test::PredictBench;
using test::unit_m;

// Steps of bounds that are tried, in 100 nm.
constexpr std::uint32_t kBoundStep = test::kSanitized ? 99'731 : 9973;

test::Point3d exact_point(const PredictBench& b, std::uint32_t u, std::uint32_t v,
                          std::uint32_t depth) {
  return test::exact_point(b.config, b.rays, u, v, depth);
}

test::Point3d float_point(const PredictBench& b, std::uint32_t u, std::uint32_t v,
                          std::uint32_t depth) {
  return test::float_point(b.config, b.rays, u, v, depth);
}

void expect_bound_kept(const PredictBench& b, Pcg32& random, int tries) {
  for (int i = 0; i < tries; ++i) {
    const std::uint32_t u = random.below(b.rays.width), v = random.below(b.rays.height);
    const std::uint32_t depth =
        1 + (random.below(4) != 0 ? random.below(65535) : random.below(3000));
    const std::uint32_t error =
        b.bounds.max_error(static_cast<std::uint16_t>(depth), b.bounds.ray_class(u / 8, v / 8));
    const double bound = bound_m(b.config, depth);
    for (const std::int64_t other : {std::int64_t{depth} - error, std::int64_t{depth} + error}) {
      if (other < 1 || other > 65535 || error == 0) continue;
      const double d = distance(exact_point(b, u, v, depth),
                                float_point(b, u, v, static_cast<std::uint32_t>(other)));
      ASSERT_LE(d, bound) << "pixel " << u << "," << v << " depth " << depth << " error " << error;
    }
  }
}

TEST(BoundTable, AnyCountWithinTheErrorKeepsThePointWithinTheBound) {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    SCOPED_TRACE(seed);
    Pcg32 random(seed);
    StreamConfig c = test::random_config(random, 120);
    const PredictBench b(c);
    expect_bound_kept(b, random, 3000);
  }
}

TEST(BoundTable, TheBoundHoldsAtTheWidestRaysAndFullDepth) {
  StreamConfig c;
  c.camera.width = c.camera.height = 17;
  c.camera.fx_q16 = c.camera.fy_q16 = 65536;
  c.camera.cx_q16 = c.camera.cy_q16 = 8 * 65536;  // rays to +-8: 85 degrees off axis
  c.camera.unit_pm = 1'000'000'000;
  c.tolerance = ToleranceKind::kMetres;
  for (std::uint32_t bound = 100'000; bound < 2'000'000; bound += kBoundStep) {
    c.tolerance_100nm = bound;
    const PredictBench b(c);
    Pcg32 random(bound);
    expect_bound_kept(b, random, 300);
    for (const std::uint32_t depth : {4095U, 8191U, 20479U, 32767U, 65000U}) {
      const std::uint32_t error =
          b.bounds.max_error(static_cast<std::uint16_t>(depth), b.bounds.ray_class(2, 2));
      ASSERT_LE(distance(exact_point(b, 16, 16, depth), float_point(b, 16, 16, depth + error)),
                bound * 1e-7)
          << bound << " " << depth;
    }
  }
}

// Bounds that some counts along the longest ray just fill leave no room but what is kept for the
// rounding of coordinates.
TEST(BoundTable, BoundsFilledToTheBrimLeaveRoomForTheRoundingToFloat) {
  StreamConfig c;
  c.camera.width = c.camera.height = 17;
  c.camera.fx_q16 = c.camera.fy_q16 = 65536;
  c.camera.cx_q16 = c.camera.cy_q16 = 8 * 65536;
  c.camera.unit_pm = 1'000'000'000;
  c.tolerance = ToleranceKind::kMetres;
  int filled = 0;
  for (std::uint32_t counts = 1; counts < 4; ++counts) {
    for (std::uint32_t more = 0; more < 24; ++more) {
      // sqrt(8^2 + 8^2 + 1) mm a count, in 0.1 um, and up to 0.1 mm.
      c.tolerance_100nm = static_cast<std::uint32_t>(counts * 113'579.0) + more * 40;
      const PredictBench b(c);
      for (std::uint32_t depth = 64'001; depth < 65'500; ++depth) {
        const std::uint32_t error =
            b.bounds.max_error(static_cast<std::uint16_t>(depth), b.bounds.ray_class(2, 2));
        filled += error == counts;
        for (const std::uint32_t side : {0U, 16U}) {
          for (const std::uint32_t other : {depth - error, depth + error}) {
            ASSERT_LE(distance(exact_point(b, side, 16, depth), float_point(b, side, 16, other)),
                      c.tolerance_100nm * 1e-7)
                << counts << " counts at " << depth;
          }
        }
      }
    }
  }
  EXPECT_GT(filled, 1000);
}

TEST(BoundTable, TheErrorUsesTheBoundUpToItsRayClassAndOneCount) {
  for (std::uint64_t seed = 100; seed < 130; ++seed) {
    Pcg32 random(seed);
    StreamConfig c = test::random_config(random, 100);
    if (c.tolerance == ToleranceKind::kLossless) continue;
    const PredictBench b(c);
    double longest = 1;
    for (std::uint32_t v = 0; v < b.rays.height; ++v) {
      for (std::uint32_t u = 0; u < b.rays.width; ++u)
        longest =
            std::max(longest, std::hypot(b.rays.x(u, v) * 0x1p-27, b.rays.y(u, v) * 0x1p-27, 1));
    }
    for (int i = 0; i < 500; ++i) {
      const std::uint32_t bx = random.below((b.rays.width + 7U) / 8);
      const std::uint32_t by = random.below((b.rays.height + 7U) / 8);
      const auto depth = static_cast<std::uint16_t>(1 + random.below(20000));
      if (depth * unit_m(c) > 100) continue;  // sigma is cut off beyond 134 m
      double own = 1;
      for (std::uint32_t v = by * 8; v < std::min<std::uint32_t>(by * 8 + 8, b.rays.height); ++v) {
        for (std::uint32_t u = bx * 8; u < std::min<std::uint32_t>(bx * 8 + 8, b.rays.width); ++u)
          own = std::max(own, std::hypot(b.rays.x(u, v) * 0x1p-27, b.rays.y(u, v) * 0x1p-27, 1));
      }
      const double upper = own + (longest - 1) / kRayClasses + 1e-3;
      const double counts = bound_m(c, depth) / unit_m(c) / upper;
      const double least = std::min(counts * 0.995 - 0.15, 60000.0) - 1;
      EXPECT_GE(b.bounds.max_error(depth, b.bounds.ray_class(bx, by)), std::floor(least)) << seed;
    }
  }
}

TEST(BoundTable, LosslessAllowsNoErrorAnywhere) {
  Pcg32 random(3);
  StreamConfig c = test::random_config(random, 60);
  c.tolerance = ToleranceKind::kLossless;
  c.drop_off_surface = false;
  const PredictBench b(c);
  EXPECT_TRUE(b.bounds.lossless());
  for (std::uint32_t d = 0; d < 65536; ++d) {
    ASSERT_EQ(b.bounds.max_error(static_cast<std::uint16_t>(d), kRayClasses - 1), 0U);
    ASSERT_EQ(b.bounds.half_widths(0)[d], 0);
  }
}

TEST(BoundTable, HalfWidthsReachTheFarthestLevelWithinTheError) {
  for (std::uint64_t seed = 40; seed < 52; ++seed) {
    Pcg32 random(seed);
    StreamConfig c = test::random_config(random, 60);
    const PredictBench b(c);
    for (const std::uint8_t ray_class : {std::uint8_t{0}, std::uint8_t{7}, std::uint8_t{15}}) {
      const std::uint8_t* half = b.bounds.half_widths(ray_class);
      std::uint32_t reach = 1;
      for (std::uint32_t l = 1; l < b.levels.count(); ++l) {
        const std::uint32_t limit =
            b.levels.depth(l) + b.bounds.max_error(b.levels.depth(l), ray_class);
        // The farthest level whose count is within the limit, never nearer than a nearer level's.
        reach = std::max(reach, l);
        while (reach + 1 < b.levels.count() && b.levels.depth(reach + 1) <= limit) ++reach;
        ASSERT_EQ(half[l], b.bounds.lossless() ? 0U : std::min<std::uint32_t>(reach - l, 255)) << l;
        ASSERT_LE(b.levels.depth(l + half[l]) - b.levels.depth(l),
                  b.bounds.max_error(b.levels.depth(l), ray_class) + 1U);
      }
    }
  }
}

TEST(BoundTable, WindowsHoldExactlyTheLevelsWithinTheError) {
  for (std::uint64_t seed = 60; seed < 68; ++seed) {
    Pcg32 random(seed);
    const PredictBench b(test::random_config(random, 60));
    const auto ray_class = static_cast<std::uint8_t>(random.below(kRayClasses));
    const LevelWindow* windows = b.bounds.windows(ray_class);
    EXPECT_EQ(windows[0].high, 0U);
    for (std::uint32_t d = 1; d < 65536; d += 1 + random.below(40)) {
      const auto depth = static_cast<std::uint16_t>(d);
      const std::uint32_t error = b.bounds.max_error(depth, ray_class);
      const auto holds = [&](std::uint32_t level) {
        return level >= 1 && level < b.levels.count() &&
               std::abs(int{b.levels.depth(level)} - int{depth}) <= static_cast<int>(error);
      };
      const LevelWindow w = windows[d];
      // All between its ends and none beside them: depths rise with levels.
      ASSERT_EQ(w.low <= w.high, holds(b.levels.nearest(depth))) << d;
      ASSERT_FALSE(holds(w.low - 1U) || holds(w.high + 1U)) << d;
      if (w.low <= w.high) {
        ASSERT_TRUE(holds(w.low) && holds(w.high)) << d;
      }
    }
  }
}

TEST(BoundTable, HugeSigmasAreCutNotWrapped) {
  StreamConfig c;
  Pcg32 random(9);
  c.camera = test::random_camera(random, 16, 16, 1.0, false);
  c.camera.unit_pm = 1'000'000'000;
  c.tolerance = ToleranceKind::kSigma;
  c.noise = {NoiseModel::Kind::kStereo, 4'000'000'000U};
  c.sigmas_q16 = 0xffffffffU;
  const PredictBench b(c);
  std::uint32_t last = 0;
  for (std::uint32_t d = 1; d < 65536; ++d) {
    const std::uint32_t error = b.bounds.max_error(static_cast<std::uint16_t>(d), 0);
    ASSERT_GE(error, last) << d;
    last = error;
  }
  EXPECT_GT(last, 60000U);
}

TEST(BoundTable, AnImageBeyondTheLayoutIsRefused) {
  Pcg32 random(4);
  StreamConfig c;
  c.camera = test::random_camera(random, 4000, 3000, 1.0, false);
  std::vector<std::int32_t> storage(ray_table_entries(c.camera));
  RayTable rays;
  ASSERT_EQ(build_ray_table(c.camera, storage, rays), Status::kOk);
  Arena arena = std::move(*Arena::map(std::size_t{8} << 20U));
  LevelTable levels;
  BoundTable bounds;
  levels.layout(arena);
  bounds.layout(arena, 64);
  ASSERT_EQ(levels.build({}), Status::kOk);
  EXPECT_EQ(bounds.build(c, rays, levels), Status::kFieldRange);
}

}  // namespace
}  // namespace planecast
