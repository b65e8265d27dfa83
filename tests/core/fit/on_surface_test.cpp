// The surfaces contract at the pixel: who is on a surface, judged again here in doubles.
#include "core/fit/on_surface.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>

#include "core/base/random.hpp"
#include "tests/core/fit/fit_bench.hpp"

namespace planecast {
namespace {

using test::FitBench;

/// A 16 x 8 image with two blocks, the level plane z = 2000 in both, the plane z = 1000 in the
/// first as its second surface.
struct TwoBlocks {
  FitBench bench{test::fit_config(16, 8, ToleranceKind::kSurfaces)};
  std::vector<Surface> surfaces{{0, 0, (1 << 30) / 1000}, {0, 0, (1 << 30) / 500}};
  std::vector<BlockLabel> labels{{1, 2}, {1, 0}};
  std::vector<std::uint16_t> depth = std::vector<std::uint16_t>(128, 2000);
  SurfaceCounts counts;

  Status drop(bool drop) {
    return drop_off_surface(bench.tables(), depth, surfaces, labels, drop, counts);
  }
  /// Pixel (u, v).
  std::uint16_t& at(std::uint32_t u, std::uint32_t v) { return depth[v * 16 + u]; }
};

TEST(DropOffSurface, ZeroesWhatLiesOnNoneOfItsBlocksSurfacesAndNothingElse) {
  TwoBlocks two;
  two.at(2, 2) = 1000;   // on the second surface of the first block
  two.at(10, 2) = 1000;  // which the second block has not
  two.at(5, 5) = 1500;   // on none
  two.at(6, 6) = 0;      // a hole
  auto expected = two.depth;
  expected[2 * 16 + 10] = expected[5 * 16 + 5] = 0;
  ASSERT_EQ(two.drop(true), Status::kOk);
  EXPECT_EQ(two.depth, expected);
  EXPECT_EQ(two.counts.on, 125U);
  EXPECT_EQ(two.counts.off, 2U);
}

TEST(DropOffSurface, OnlyCountsWhenItIsToKeep) {
  TwoBlocks two;
  two.at(5, 5) = 1500;
  const auto before = two.depth;
  ASSERT_EQ(two.drop(false), Status::kOk);
  EXPECT_EQ(two.depth, before);
  EXPECT_EQ(two.counts.on, 127U);
  EXPECT_EQ(two.counts.off, 1U);
}

TEST(DropOffSurface, OfABlockWithoutSurfacesEverythingIsOff) {
  TwoBlocks two;
  two.labels[1] = {};
  ASSERT_EQ(two.drop(true), Status::kOk);
  EXPECT_EQ(two.counts.on, 64U);
  EXPECT_EQ(two.counts.off, 64U);
  EXPECT_EQ(std::ranges::count(two.depth, 0), 64);
}

TEST(DropOffSurface, ASurfaceBehindTheCameraHoldsNothing) {
  TwoBlocks two;
  two.surfaces[0].c = -two.surfaces[0].c;
  ASSERT_EQ(two.drop(true), Status::kOk);
  EXPECT_EQ(two.counts.on, 0U);
}

TEST(DropOffSurface, RefusesSpansOfAnotherSize) {
  TwoBlocks two;
  two.labels.pop_back();
  EXPECT_EQ(two.drop(true), Status::kWrongSize);
  two.labels.push_back({});
  two.depth.pop_back();
  EXPECT_EQ(two.drop(true), Status::kWrongSize);
}

// A row of four blocks whose first alone has cells of a region: how far its surface goes.
TEST(LabelOnSurface, ASurfaceGoesOnThroughBlocksWithoutOneWhereItHoldsHalfOfTheReadings) {
  for (const std::uint32_t held : {31U, 32U}) {
    FitBench bench(test::fit_config(32, 8, ToleranceKind::kSurfaces));
    std::vector<std::uint16_t> depth(32 * 8, 2000);
    for (std::uint32_t i = held; i < 64; ++i) depth[i / 8 * 32 + 24 + i % 8] = 3000;
    std::vector<std::uint8_t> cells(8 * 2);
    cells[0] = cells[1] = cells[8] = cells[9] = 1;
    const RegionMap regions{8, 2, {}, cells, 1};
    const std::array<std::uint8_t, 2> surface_of{0, 1};
    std::vector<Surface> surfaces(1);
    surfaces[0].c = static_cast<std::int32_t>(0x80000000U / 2000);
    std::vector<std::uint64_t> off(4);
    label_on_surface(bench.tables(), depth, regions, surface_of, surfaces, bench.labels, off);
    for (int block = 0; block < 3; ++block) {
      EXPECT_EQ(bench.labels[block].first, 1) << block;
      EXPECT_EQ(off[block], 0U) << block;
    }
    EXPECT_EQ(bench.labels[3].first, held == 32 ? 1 : 0);
    EXPECT_EQ(bench.labels[3].second, 0);
    EXPECT_EQ(std::popcount(off[3]), held == 32 ? 32 : 64);
  }
}

// What is left stands within K sigma of one of its block's planes, by the distance along the ray.
TEST(DropOffSurface, WhatIsKeptLiesWithinTheBoundInDoubles) {
  FitBench bench(test::fit_config(320, 240, ToleranceKind::kSurfaces));
  std::vector<std::uint16_t> depth(320 * 240);
  Pcg32 random(21);
  for (std::uint32_t i = 0; i < depth.size(); ++i) {
    const double z = test::plane_depth(bench.rays, i % 320, i / 320, 1e-4, 5e-5, 4e-4);
    const std::uint32_t reach = random.below(10) == 0 ? 100 : 20;
    depth[i] = static_cast<std::uint16_t>(z + random.below(2 * reach + 1) - reach);
  }
  ASSERT_EQ(bench.run(depth), Status::kOk);
  ASSERT_GE(bench.report.surfaces, 1U);
  const auto surfaces = std::span(bench.surfaces).first(bench.report.surfaces);
  SurfaceCounts counts;
  ASSERT_EQ(drop_off_surface(bench.tables(), depth, surfaces, bench.labels, true, counts),
            Status::kOk);
  ASSERT_GT(counts.on, 1000U);
  ASSERT_GT(counts.off, 1000U);
  for (std::uint32_t i = 0; i < depth.size(); ++i) {
    if (depth[i] == 0) continue;
    const std::uint32_t u = i % 320, v = i / 320;
    const double x = bench.rays.x(u, v) * 0x1p-27, y = bench.rays.y(u, v) * 0x1p-27;
    const BlockLabel label = bench.labels[v / 8 * 40 + u / 8];
    const double z_m = depth[i] * 1e-3;
    double nearest = 1e9;
    for (const std::uint8_t k : {label.first, label.second}) {
      if (k == 0) continue;
      const Surface& s = surfaces[k - 1U];
      const double on_plane_m = 0x1p31 / (s.a * x + s.b * y + s.c) * 1e-3;
      nearest = std::min(nearest, std::abs(on_plane_m - z_m) * std::sqrt(x * x + y * y + 1));
    }
    // Half a count: the surface's depth is a whole one.
    EXPECT_LE(nearest, 3 * bench.config.noise.sigma_m(z_m) + 0.0005 * 1.3) << u << ", " << v;
  }
}

}  // namespace
}  // namespace planecast
