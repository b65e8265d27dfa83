// Fitting recovers planes, labels only what pays, splits what holds two planes, and keeps the
// promises of rounding and of the surfaces contract.
#include "core/fit/surface_fitter.hpp"

#include <algorithm>
#include <cstdlib>

#include "core/base/random.hpp"
#include "core/fit/on_surface.hpp"
#include "core/fit/surface_quantise.hpp"
#include "core/predict/block_surface.hpp"
#include "tests/core/fit/fit_bench.hpp"

namespace planecast {
namespace {

using test::fit_config;
using test::FitBench;
using test::plane_depth;

double gaussian(Pcg32& random) {
  double sum = -6;
  for (int i = 0; i < 12; ++i) sum += random.uniform();
  return sum;
}

// A plane with stereo noise of `sigmas` times 0.002 z^2 [m].
std::vector<std::uint16_t> noisy_plane(const RayTable& rays, double a, double b, double c,
                                       double sigmas, std::uint64_t seed) {
  Pcg32 random(seed);
  std::vector<std::uint16_t> out;
  for (std::uint32_t v = 0; v < rays.height; ++v) {
    for (std::uint32_t u = 0; u < rays.width; ++u) {
      const double z = plane_depth(rays, u, v, a, b, c);
      out.push_back(static_cast<std::uint16_t>(
          std::lround(z + sigmas * 0.002 * 0.001 * z * z * gaussian(random))));
    }
  }
  return out;
}

std::vector<std::uint16_t> corner_of_two_walls(const RayTable& rays) {
  std::vector<std::uint16_t> out;
  for (std::uint32_t v = 0; v < rays.height; ++v) {
    for (std::uint32_t u = 0; u < rays.width; ++u) {
      const double z =
          std::min(plane_depth(rays, u, v, 2e-4, 0, 4e-4), plane_depth(rays, u, v, -2e-4, 0, 4e-4));
      out.push_back(static_cast<std::uint16_t>(std::lround(z)));
    }
  }
  return out;
}

TEST(SurfaceFitter, RecoversANoisyPlaneWithinAQuarterSigmaAtEveryPixel) {
  FitBench bench(fit_config(320, 240, ToleranceKind::kMetres));
  const double a = 1e-4, b = -5e-5, c = 5e-4;
  ASSERT_EQ(bench.run(noisy_plane(bench.rays, a, b, c, 1, 5)), Status::kOk);
  ASSERT_EQ(bench.report.surfaces, 1U);
  for (std::uint32_t v = 0; v < 240; v += 7) {
    for (std::uint32_t u = 0; u < 320; u += 7) {
      const double z = plane_depth(bench.rays, u, v, a, b, c);
      const double found = surface_depth(bench.surfaces[0], bench.rays.x(u, v), bench.rays.y(u, v));
      EXPECT_NEAR(found, z, 0.25 * 2e-6 * z * z + 0.5) << u << ", " << v;
    }
  }
}

TEST(SurfaceFitter, FindsBothWallsOfACornerAndLabelsTheirSides) {
  FitBench bench(fit_config(320, 240, ToleranceKind::kSurfaces));
  const std::vector<std::uint16_t> depth = corner_of_two_walls(bench.rays);
  ASSERT_EQ(bench.run(depth), Status::kOk);
  ASSERT_GE(bench.report.surfaces, 2U);
  EXPECT_NE(bench.labels[15 * 40 + 2].first, bench.labels[15 * 40 + 37].first);
  std::vector<std::uint16_t> dropped = depth;
  SurfaceCounts counts;
  ASSERT_EQ(drop_off_surface(bench.tables(), dropped,
                             std::span(bench.surfaces).first(bench.report.surfaces), bench.labels,
                             true, counts),
            Status::kOk);
  EXPECT_GT(counts.on, depth.size() * 9 / 10);
  EXPECT_EQ(counts.on + counts.off, depth.size());
  EXPECT_EQ(std::count(dropped.begin(), dropped.end(), 0), counts.off);
}

TEST(SurfaceFitter, NeverLabelsNoise) {
  for (const auto kind : {ToleranceKind::kLossless, ToleranceKind::kMetres}) {
    FitBench bench(fit_config(320, 240, kind));
    Pcg32 random(11);
    std::vector<std::uint16_t> depth(320 * 240);
    for (std::uint16_t& d : depth) d = static_cast<std::uint16_t>(500 + random.below(8000));
    ASSERT_EQ(bench.run(depth), Status::kOk);
    EXPECT_EQ(bench.report.labelled_blocks, 0U);
  }
}

TEST(SurfaceFitter, GivesTheSameAnswerEveryTime) {
  FitBench first(fit_config(320, 240)), second(fit_config(320, 240));
  const auto depth = noisy_plane(first.rays, 1e-4, 2e-5, 4e-4, 1, 9);
  ASSERT_EQ(first.run(depth), Status::kOk);
  ASSERT_EQ(second.run(depth), Status::kOk);
  ASSERT_EQ(second.run(depth), Status::kOk);
  EXPECT_EQ(first.surfaces, second.surfaces);
  EXPECT_EQ(first.report.shift, second.report.shift);
  for (std::size_t i = 0; i < first.labels.size(); ++i) {
    EXPECT_EQ(first.labels[i].first, second.labels[i].first);
  }
}

TEST(SurfaceFitter, TakesDegenerateFrames) {
  for (const auto kind : {ToleranceKind::kLossless, ToleranceKind::kSurfaces}) {
    for (const auto& [w, h] : {std::pair{1U, 1U}, {320U, 1U}, {1U, 240U}, {7U, 5U}, {64U, 48U}}) {
      for (const int value : {0, 1, 1000, 65535}) {
        FitBench bench(fit_config(w, h, kind));
        EXPECT_EQ(bench.run(std::vector<std::uint16_t>(w * h, static_cast<std::uint16_t>(value))),
                  Status::kOk);
        if (value == 0) EXPECT_EQ(bench.report.labelled_blocks, 0U);
        for (const BlockLabel& label : bench.labels) {
          EXPECT_LE(label.first, bench.report.surfaces);
          EXPECT_LE(label.second, bench.report.surfaces);
        }
      }
    }
  }
}

TEST(SurfaceFitter, RefusesSpansOfAnotherSize) {
  FitBench bench(fit_config(64, 48));
  ASSERT_EQ(bench.run(std::vector<std::uint16_t>(64 * 48, 1000)), Status::kOk);
  EXPECT_EQ(bench.fitter.fit(bench.tables(), std::vector<std::uint16_t>(9), bench.regions,
                             bench.labels, bench.surfaces, bench.report),
            Status::kWrongSize);
}

TEST(Consensus, SplitsARegionThatHoldsTwoPlanes) {
  FitBench bench(fit_config(320, 240));
  ASSERT_EQ(bench.run(corner_of_two_walls(bench.rays)), Status::kOk);
  std::fill(bench.regions.labels.begin(), bench.regions.labels.end(), std::uint8_t{1});
  bench.regions.regions = 1;
  std::vector<RegionFit> fits(kMaxSurfaces);
  std::vector<std::uint32_t> scratch(bench.regions.cells.size());
  fit_regions(bench.regions, fits);
  ASSERT_GT(fits[0].residual, 3);
  EXPECT_EQ(split_regions(bench.regions, fits, scratch, {}), 1);
  EXPECT_GE(bench.regions.regions, 2);
  EXPECT_LT(fits[0].residual, 1);
  EXPECT_LT(fits[1].residual, 1);
  EXPECT_NE(bench.regions.labels[15 * 40 + 2], bench.regions.labels[15 * 40 + 37]);
}

TEST(Consensus, LeavesTheFitsOfAllRegionsAsFittingThemAllWould) {
  FitBench bench(fit_config(320, 240));
  ASSERT_EQ(bench.run(corner_of_two_walls(bench.rays)), Status::kOk);
  // The upper half keeps its two regions, the lower half holds both planes in one.
  for (std::size_t i = 0; i < bench.regions.labels.size(); ++i) {
    const std::uint8_t half = i % 40 < 20 ? 1 : 2;
    bench.regions.labels[i] = i < 15 * 40 ? half : std::uint8_t{3};
  }
  bench.regions.regions = 3;
  std::vector<RegionFit> fits(kMaxSurfaces), all(kMaxSurfaces);
  std::vector<std::uint32_t> scratch(bench.regions.cells.size());
  fit_regions(bench.regions, fits);
  ASSERT_EQ(split_regions(bench.regions, fits, scratch, {}), 1);
  ASSERT_GE(bench.regions.regions, 4);
  fit_regions(bench.regions, all);
  for (int k = 0; k < bench.regions.regions; ++k) {
    EXPECT_EQ(fits[k].cells, all[k].cells) << k;
    EXPECT_EQ(fits[k].residual, all[k].residual) << k;
    EXPECT_EQ(fits[k].surface.c, all[k].surface.c) << k;
  }
}

TEST(SurfaceQuantise, RoundingMovesNoPixelByMoreThanItsShareOfSigma) {
  Pcg32 random(3);
  const FitBench bench(fit_config(160, 120));
  for (int trial = 0; trial < 200; ++trial) {
    const bool curved = trial % 2 != 0;
    const double ray_sum = largest_ray_sum(bench.rays, curved);
    RegionFit fit;
    fit.valid = true;
    fit.min_sigma = 20 + 20000 * random.uniform();
    fit.surface = {4e6 * (random.uniform() - 0.5), 4e6 * (random.uniform() - 0.5),
                   5e6 * random.uniform()};
    if (curved) {
      fit.surface.d = 4e6 * (random.uniform() - 0.5);
      fit.surface.e = 4e6 * (random.uniform() - 0.5);
      fit.surface.f = 4e6 * (random.uniform() - 0.5);
    }
    const int shift = choose_shift({&fit, 1}, ray_sum);
    Surface surface;
    ASSERT_TRUE(quantise_surface(fit.surface, shift, surface));
    const std::int32_t mask = (1 << shift) - 1;
    EXPECT_EQ((surface.a | surface.b | surface.c) & mask, 0);
    EXPECT_EQ((surface.d | surface.e | surface.f) & mask, 0);
    for (const std::uint32_t v : {0U, 60U, 119U}) {
      for (const std::uint32_t u : {0U, 80U, 159U}) {
        const std::int32_t x = bench.rays.x(u, v), y = bench.rays.y(u, v);
        const double exact = fit.surface.at(x * 0x1p-27, y * 0x1p-27);
        EXPECT_LE(std::abs(static_cast<double>(surface.inverse_depth(x, y)) - exact),
                  kRoundingShare * fit.min_sigma + (curved ? 10 : 1.5));
      }
    }
  }
  Surface out;
  EXPECT_FALSE(quantise_surface({3e9, 0, 0}, 0, out));
}

}  // namespace
}  // namespace planecast
