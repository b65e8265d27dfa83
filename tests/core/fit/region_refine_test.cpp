// Refined regions hold what coarse cells miss: narrow faces, borders inside a cell, parts of one
// wall; and cells are measured as one would by hand.
#include "core/fit/region_refine.hpp"

#include <algorithm>
#include <set>

#include "core/base/random.hpp"
#include "tests/core/fit/fit_bench.hpp"

namespace planecast {
namespace {

using test::fit_config;
using test::FitBench;
using test::plane_depth;

// Depth of a wall at 2 m, with noise of `sigmas` times 0.002 z^2 [m], and what `inside(u, v)` says
// 0.4 m before it.
template <class F>
std::vector<std::uint16_t> wall_with(const RayTable& rays, double sigmas, F&& inside) {
  Pcg32 random(7);
  std::vector<std::uint16_t> out;
  for (std::uint32_t v = 0; v < rays.height; ++v) {
    for (std::uint32_t u = 0; u < rays.width; ++u) {
      double gauss = -6;
      for (int i = 0; i < 12; ++i) gauss += random.uniform();
      const double z = inside(u, v) ? 1600 : plane_depth(rays, u, v, 1e-5, 0, 5e-4);
      out.push_back(static_cast<std::uint16_t>(std::lround(z + sigmas * 2e-6 * z * z * gauss)));
    }
  }
  return out;
}

std::uint8_t label_at(const RegionMap& map, std::uint32_t u, std::uint32_t v) {
  return map.labels[std::size_t{v / kFineSide} * map.cells_wide + u / kFineSide];
}

TEST(FineCells, HaveTheMomentsOfTheirReadings) {
  const FitBench bench(fit_config(66, 50, ToleranceKind::kSurfaces));
  auto depth = wall_with(bench.rays, 1, [](auto, auto) { return false; });
  Pcg32 random(3);
  for (std::uint16_t& d : depth) d = random.below(10) == 0 ? std::uint16_t{0} : d;
  std::vector<Cell> cells(std::size_t{fine_cells(66)} * fine_cells(50));
  measure_fine_cells(bench.tables(), depth, 1.0F, cells);
  for (std::uint32_t cy = 0; cy < fine_cells(50); ++cy) {
    for (std::uint32_t cx = 0; cx < fine_cells(66); ++cx) {
      double n = 0, x = 0, w = 0;
      for (std::uint32_t v = 4 * cy; v < std::min(4 * cy + 4, 50U); ++v) {
        for (std::uint32_t u = 4 * cx; u < std::min(4 * cx + 4, 66U); ++u) {
          const std::uint16_t d = depth[v * 66 + u];
          if (d == 0) continue;
          n += 1;
          x += bench.rays.x(u, v) * 0x1p-27;
          w += 0x1p31 / d;
        }
      }
      const Cell& cell = cells[cy * fine_cells(66) + cx];
      ASSERT_EQ(double{cell.n}, n);
      if (n == 0) continue;
      EXPECT_NEAR(double{cell.x}, x / n, 1e-5);
      EXPECT_NEAR(double{cell.w}, w / n, 1e-5 * w / n);
      Cell part;
      const std::uint32_t all = cell_readings(bench.rays, depth, 4 * cx, 4 * cy);
      measure_part(bench.tables(), depth, 4 * cx, 4 * cy, all, 1.0F, part);
      EXPECT_EQ(part.n, cell.n);
      EXPECT_NEAR(double{part.w}, double{cell.w}, 1e-6 * double{cell.w});
      EXPECT_EQ(part.usable, cell.usable);
    }
  }
}

TEST(RegionRefiner, FindsAPostThatIsNarrowerThanACoarseCell) {
  FitBench bench(fit_config(320, 240, ToleranceKind::kSurfaces));
  // 7 px wide, so that it fills no column of coarse cells and one of fine ones at most.
  const auto post = [](std::uint32_t u, std::uint32_t v) {
    return u >= 101 + v / 60 && u < 108 + v / 60;
  };
  ASSERT_EQ(bench.run(wall_with(bench.rays, 1, post)), Status::kOk);
  ASSERT_EQ(bench.regions.regions, 1);
  const RegionMap& map = bench.fitter.refined();
  std::set<std::uint8_t> of_post;
  for (std::uint32_t v = 20; v < 220; v += 20) of_post.insert(label_at(map, 104 + v / 60, v));
  of_post.erase(0);
  EXPECT_EQ(of_post.size(), 1U);
  EXPECT_FALSE(of_post.contains(label_at(map, 20, 20)));
  EXPECT_EQ(bench.report.surfaces, 2U);
  EXPECT_EQ(label_at(map, 20, 20), label_at(map, 300, 200)) << "the wall goes on behind it";
}

TEST(RegionRefiner, DrawsBordersAtFineCells) {
  FitBench bench(fit_config(320, 240, ToleranceKind::kSurfaces));
  // The border lies in the middle of coarse cells.
  const auto step = [](std::uint32_t u, std::uint32_t) { return u < 164; };
  ASSERT_EQ(bench.run(wall_with(bench.rays, 1, step)), Status::kOk);
  const RegionMap& map = bench.fitter.refined();
  for (std::uint32_t v = 0; v < 240; v += 4) {
    EXPECT_EQ(label_at(map, 160, v), label_at(map, 4, 4)) << v;
    EXPECT_EQ(label_at(map, 164, v), label_at(map, 316, 4)) << v;
  }
  EXPECT_NE(label_at(map, 4, 4), label_at(map, 316, 4));
}

TEST(RegionRefiner, JoinsPartsOfOneWallAndLeavesACornerAlone) {
  const auto parts = [](FitBench& bench, const std::vector<std::uint16_t>& depth) {
    EXPECT_EQ(bench.segmenter.process(bench.config, bench.rays, depth, bench.regions), Status::kOk);
    RegionMap& regions = bench.regions;
    for (std::size_t i = 0; i < regions.labels.size(); ++i)
      regions.labels[i] = i % regions.cells_wide < regions.cells_wide / 2 ? 1 : 2;
    regions.regions = 2;
    EXPECT_EQ(bench.fitter.fit(bench.tables(), depth, regions, bench.labels, bench.surfaces,
                               bench.report),
              Status::kOk);
    return bench.report.surfaces;
  };
  FitBench wall(fit_config(320, 240, ToleranceKind::kSurfaces));
  EXPECT_EQ(parts(wall, wall_with(wall.rays, 1, [](auto, auto) { return false; })), 1U);
  FitBench corner(fit_config(320, 240, ToleranceKind::kSurfaces));
  std::vector<std::uint16_t> depth;
  for (std::uint32_t v = 0; v < 240; ++v) {
    for (std::uint32_t u = 0; u < 320; ++u) {
      const double sign = u < 160 ? -1e-4 : 1e-4;
      depth.push_back(
          static_cast<std::uint16_t>(std::lround(plane_depth(corner.rays, u, v, sign, 0, 4e-4))));
    }
  }
  EXPECT_EQ(parts(corner, depth), 2U);
}

TEST(RegionRefiner, JoinsPlanesThatWereTurnedIntoOneAndNoOthers) {
  FitBench bench(fit_config(320, 240, ToleranceKind::kSurfaces));
  // The left third stands 14 mm before the rest, not twice the noise there.
  auto depth = wall_with(bench.rays, 1, [](auto, auto) { return false; });
  for (std::size_t i = 0; i < depth.size(); ++i)
    depth[i] = static_cast<std::uint16_t>(depth[i] - (i % 320 < 104 ? 14 : 0));
  ASSERT_EQ(bench.segmenter.process(bench.config, bench.rays, depth, bench.regions), Status::kOk);
  for (std::size_t i = 0; i < bench.regions.labels.size(); ++i)
    bench.regions.labels[i] = i % bench.regions.cells_wide < 13 ? 1 : 2;
  bench.regions.regions = 2;
  std::vector<RegionFit> fits(kMaxSurfaces);
  fit_regions(bench.regions, fits);
  Arena arena = std::move(*Arena::map(4U << 20U));
  RegionRefiner refiner;
  refiner.layout(arena, 320, 240);
  const RegionMap map = refiner.process(bench.tables(), depth, bench.regions, fits);
  const std::uint8_t small = label_at(map, 4, 4), large = label_at(map, 316, 4);
  ASSERT_NE(small, large);

  refiner.join_same(fits);
  EXPECT_EQ(label_at(map, 4, 4), small) << "twice the noise apart";
  EXPECT_TRUE(fits[small - 1U].valid && fits[large - 1U].valid);

  fits[small - 1U].surface = fits[large - 1U].surface;
  refiner.join_same(fits);
  EXPECT_EQ(label_at(map, 4, 4), large);
  EXPECT_EQ(label_at(map, 316, 4), large);
  EXPECT_FALSE(fits[small - 1U].valid);
  EXPECT_TRUE(fits[large - 1U].valid);
}

}  // namespace
}  // namespace planecast
