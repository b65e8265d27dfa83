// Surfaces within a block and at a pixel against exact arithmetic.
#include "core/predict/block_surface.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/core/model/random_config.hpp"
#include "tests/core/predict/predict_bench.hpp"

namespace planecast {
namespace {

using test::PredictBench;

TEST(SurfaceDepth, IsTheRoundedQuotientForEveryInverseDepth) {
  Pcg32 random(31);
  const auto expect_rounded = [](std::int64_t iv) {
    const Surface flat{0, 0, static_cast<std::int32_t>(iv)};
    // round(2^31 / iv), halves up: floor((2^32 + iv) / (2 iv)).
    const std::int64_t exact = ((std::int64_t{1} << 32) + iv) / (2 * iv);
    ASSERT_EQ(surface_depth(flat, 0, 0), exact > 65535 ? 0 : exact) << iv;
  };
  for (std::int64_t iv = 32768; iv < 200'000; ++iv) expect_rounded(iv);
  for (int i = 0; i < 100'000; ++i)
    expect_rounded(32768 + (random.next() >> (2 + random.below(14))));
  expect_rounded(kMaxSurfaceCoefficient);
}

TEST(SurfaceDepth, IsNoReadingBehindTheCameraAndBeyondTheRange) {
  EXPECT_EQ(surface_depth({0, 0, 32767}, 0, 0), 0);
  EXPECT_EQ(surface_depth({0, 0, 0}, 0, 0), 0);
  EXPECT_EQ(surface_depth({0, 0, -70000}, 0, 0), 0);
  EXPECT_EQ(surface_depth({1 << 29, 0, 0}, -(1 << 27), 0), 0);
}

TEST(SurfaceDepth, NeverGrowsAsTheInverseDepthGrows) {
  std::uint16_t last = 65535;
  for (std::int32_t iv = 32769; iv < (1 << 30) - 70000; iv += 1 + iv / 3000) {
    const std::uint16_t depth = surface_depth({0, 0, iv}, 0, 0);
    ASSERT_LE(depth, last) << iv;
    last = depth;
  }
}

TEST(BlockSurface, IsExactAtTheMiddleAndNearEverywhereInTheBlock) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    Pcg32 random(seed);
    StreamConfig c;
    c.camera = test::random_camera(random, 1 + random.below(200), 1 + random.below(200), 1.0, true);
    c.lattice = seed % 2 == 0 ? Lattice{} : Lattice{400'000U * 256U, 0, false};
    const PredictBench b(c);
    for (int i = 0; i < 50; ++i) {
      const double near_counts = test::between(random, 800, 4000);
      const auto c_iv = static_cast<std::int32_t>(0x1p31 / near_counts);
      const Surface s{static_cast<std::int32_t>(c_iv * test::between(random, -0.3, 0.3)),
                      static_cast<std::int32_t>(c_iv * test::between(random, -0.3, 0.3)), c_iv};
      const std::uint32_t bx = random.below((b.rays.width + 7U) / 8);
      const std::uint32_t by = random.below((b.rays.height + 7U) / 8);
      const BlockSurface block = block_surface(s, b.rays, b.levels, bx, by);
      const std::uint32_t u1 = std::min<std::uint32_t>(bx * 8 + 7, b.rays.width - 1U);
      const std::uint32_t v1 = std::min<std::uint32_t>(by * 8 + 7, b.rays.height - 1U);
      const std::uint32_t um = (bx * 8 + u1) / 2, vm = (by * 8 + v1) / 2;
      const auto exact = [&](std::uint32_t u, std::uint32_t v) {
        return b.levels.level_q8(s.inverse_depth(b.rays.x(u, v), b.rays.y(u, v)));
      };
      ASSERT_EQ(block.at(um - bx * 8, vm - by * 8), exact(um, vm));
      // Slopes are secants, so the error is the curvature over half a block: a small part of the
      // change across it.
      const double change = 8.0 * (std::abs(block.dx) + std::abs(block.dy));
      for (std::uint32_t v = by * 8; v <= v1; ++v) {
        for (std::uint32_t u = bx * 8; u <= u1; ++u) {
          ASSERT_NEAR(block.at(u - bx * 8, v - by * 8), exact(u, v), 64 + 0.2 * change)
              << seed << " " << u << "," << v;
        }
      }
    }
  }
}

TEST(BlockSurface, ABlockOfOnePixelHasNoSlopes) {
  StreamConfig c;
  Pcg32 random(2);
  c.camera = test::random_camera(random, 9, 17, 1.0, false);
  const PredictBench b(c);
  const BlockSurface corner = block_surface({1 << 20, 1 << 20, 1 << 20}, b.rays, b.levels, 1, 2);
  EXPECT_EQ(corner.dx, 0);
  EXPECT_EQ(corner.dy, 0);
}

TEST(BlockSurface, StaysInRangeForSurfacesThatNoSensorSees) {
  StreamConfig c;
  c.camera.width = c.camera.height = 16;
  c.camera.fx_q16 = c.camera.fy_q16 = 2 * 65536;
  c.camera.cx_q16 = c.camera.cy_q16 = 8 * 65536;
  c.camera.unit_pm = 1'000'000'000;
  const PredictBench b(c);
  Pcg32 random(3);
  for (int i = 0; i < 20000; ++i) {
    const auto coefficient = [&] {
      const auto m = static_cast<std::int32_t>(random.next() >> (2 + random.below(30)));
      return random.below(2) != 0 ? m : -m;
    };
    const Surface s{coefficient(), coefficient(), coefficient()};
    const BlockSurface block = block_surface(s, b.rays, b.levels, random.below(2), random.below(2));
    for (std::uint32_t at = 0; at < 64; ++at)
      ASSERT_LT(std::abs(block.at(at % 8, at / 8)), 1 << 29);
  }
}

}  // namespace
}  // namespace planecast
