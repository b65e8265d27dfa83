// Degree two gives way to planes where they say the same, and stays where things are round.
#include "core/fit/curved_regions.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

#include "core/base/random.hpp"

namespace planecast {
namespace {

constexpr std::uint32_t kSide = 24;

// One region of degree two over kSide x kSide cells of 16 readings whose inverse depth is f(x, y)
// of -0.5 <= x, y < 0.5 plus noise of deviation 1 a reading.
struct CurvedRegion {
  std::vector<Cell> cells;
  std::vector<std::uint8_t> labels = std::vector<std::uint8_t>(kSide * kSide, 1);
  std::vector<RegionFit> fits = std::vector<RegionFit>(kMaxSurfaces);
  std::vector<std::uint32_t> scratch = std::vector<std::uint32_t>(kSide * kSide);
  RegionMap map;

  explicit CurvedRegion(const std::function<double(double, double)>& f) {
    Pcg32 random(5);
    QuadricSums sums;
    constexpr double kStep = 0.25 / kSide;
    for (std::uint32_t i = 0; i < kSide * kSide; ++i) {
      const double x = (i % kSide) / double{kSide} - 0.5, y = (i / kSide) / double{kSide} - 0.5;
      Cell cell;
      cell.n = 16;
      cell.x = static_cast<float>(x);
      cell.y = static_cast<float>(y);
      cell.xx = cell.yy = static_cast<float>(kStep * kStep);
      double gauss = -6;
      for (int k = 0; k < 12; ++k) gauss += random.uniform();
      cell.w = static_cast<float>(f(x, y) + gauss / 4);
      cell.a = static_cast<float>((f(x + kStep, y) - f(x - kStep, y)) / (2 * kStep));
      cell.b = static_cast<float>((f(x, y + kStep) - f(x, y - kStep)) / (2 * kStep));
      cell.own = cell.variance = 1;
      cell.usable = cell.flat = true;
      cells.push_back(cell);
      add_cell(sums, cell);
    }
    double mean_square = 0;
    fits[0].valid = sums.solve(fits[0].surface, mean_square);
    EXPECT_TRUE(fits[0].valid && fits[0].surface.curved());
    map = {kSide, kSide, cells, labels, 1, 2, 1};
  }
  int flatten() { return flatten_curved(map, fits, scratch); }
};

TEST(CurvedRegions, BecomeAPlaneWhereOnlyNoiseBendsThem) {
  CurvedRegion region([](double x, double y) { return 1000 + 30 * x - 20 * y; });
  EXPECT_EQ(region.flatten(), 1);
  EXPECT_EQ(region.map.curved, 0U);
  EXPECT_EQ(region.map.regions, 1);
  EXPECT_FALSE(region.fits[0].surface.curved());
  EXPECT_NEAR(region.fits[0].surface.a, 30, 0.5);
  EXPECT_NEAR(region.fits[0].surface.b, -20, 0.5);
}

TEST(CurvedRegions, BecomeTwoPlanesWhereTheyCrossAnEdge) {
  for (const double at : {-0.2, 0.0, 0.25}) {
    CurvedRegion region([&](double x, double y) { return 1000 + 16 * std::abs(x - at) + 5 * y; });
    EXPECT_EQ(region.flatten(), 1) << at;
    EXPECT_EQ(region.map.curved, 0U);
    ASSERT_EQ(region.map.regions, 2);
    const double low = std::min(region.fits[0].surface.a, region.fits[1].surface.a);
    const double high = std::max(region.fits[0].surface.a, region.fits[1].surface.a);
    EXPECT_NEAR(low, -16, 1.5) << at;
    EXPECT_NEAR(high, 16, 1.5) << at;
    // The edge is where it was.
    std::uint32_t left = 0;
    for (std::uint32_t i = 0; i < kSide * kSide; ++i) {
      const bool before = double{region.cells[i].x} < at;
      const FloatSurface& plane = region.fits[region.labels[i] - 1U].surface;
      left += (plane.a < 0) == before ? 1U : 0U;
    }
    EXPECT_GT(left, kSide * kSide * 9 / 10) << at;
  }
}

TEST(CurvedRegions, StayWhereThingsAreRound) {
  CurvedRegion bowl([](double x, double y) { return 1000 + 40 * (x * x + y * y); });
  CurvedRegion pillar([](double x, double y) { return 1000 - 60 * x * x + 3 * y; });
  for (CurvedRegion* region : {&bowl, &pillar}) {
    EXPECT_EQ(region->flatten(), 0);
    EXPECT_EQ(region->map.curved, 2U);
    EXPECT_EQ(region->map.regions, 1);
    EXPECT_TRUE(region->fits[0].surface.curved());
  }
}

}  // namespace
}  // namespace planecast
