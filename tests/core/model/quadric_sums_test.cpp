// Least squares of degree two from patches: exact on what it can say, the same whether patches come
// at once or as merged sums, and close where a patch bends a little.
#include "core/model/quadric_sums.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "core/base/random.hpp"
#include "core/model/region_map.hpp"

namespace planecast {
namespace {

// Patches of 8 x 8 readings of a surface over rays 1/400 apart, as cells measure them.
std::vector<QuadricPatch> patches_of(const FloatSurface& s, double noise, Pcg32& random) {
  std::vector<QuadricPatch> out;
  constexpr int kSide = 8;
  for (int py = 0; py < 10; ++py) {
    for (int px = 0; px < 12; ++px) {
      double n = 0, x = 0, y = 0, w = 0, xx = 0, xy = 0, yy = 0, xw = 0, yw = 0, ww = 0;
      for (int v = 0; v < kSide; ++v) {
        for (int u = 0; u < kSide; ++u) {
          const double rx = (px * kSide + u - 40) / 400.0, ry = (py * kSide + v - 30) / 400.0;
          const double rw = s.at(rx, ry) + noise * (random.uniform() - 0.5);
          n += 1;
          x += rx;
          y += ry;
          w += rw;
          xx += rx * rx;
          xy += rx * ry;
          yy += ry * ry;
          xw += rx * rw;
          yw += ry * rw;
          ww += rw * rw;
        }
      }
      const double mx = x / n, my = y / n, mw = w / n;
      const double cxx = xx / n - mx * mx, cxy = xy / n - mx * my, cyy = yy / n - my * my;
      const double cxw = xw / n - mx * mw, cyw = yw / n - my * mw, cww = ww / n - mw * mw;
      const double det = cxx * cyy - cxy * cxy;
      const double a = (cxw * cyy - cyw * cxy) / det, b = (cyw * cxx - cxw * cxy) / det;
      out.push_back({n, mx, my, mw, cxx, cxy, cyy, a, b, cww - a * cxw - b * cyw});
    }
  }
  return out;
}

constexpr FloatSurface kBent{3e5, -2e5, 1.5e6, 8e5, -4e5, 1.1e6};

TEST(QuadricSums, FindTheSurfaceThatTheReadingsLieOn) {
  Pcg32 random(1);
  QuadricSums sums;
  for (const QuadricPatch& patch : patches_of(kBent, 0, random)) sums.add_patch(patch);
  FloatSurface found;
  double mean_square = 0;
  ASSERT_TRUE(sums.solve(found, mean_square));
  for (const double x : {-0.1, 0.0, 0.13}) {
    for (const double y : {-0.07, 0.0, 0.12}) EXPECT_NEAR(found.at(x, y), kBent.at(x, y), 30);
  }
  EXPECT_LT(mean_square, 100 * 100);  // what bends within a patch
}

TEST(QuadricSums, LeaveTheNoiseAsResidual) {
  Pcg32 random(2);
  QuadricSums sums;
  for (const QuadricPatch& patch : patches_of(kBent, 6000, random)) sums.add_patch(patch);
  FloatSurface found;
  double mean_square = 0;
  ASSERT_TRUE(sums.solve(found, mean_square));
  EXPECT_NEAR(mean_square, 6000.0 * 6000 / 12, 0.05 * 6000 * 6000 / 12);
}

TEST(QuadricSums, MergedSumsAreThoseOfAllPatches) {
  Pcg32 random(3);
  QuadricSums all, left, right;
  int i = 0;
  for (const QuadricPatch& patch : patches_of(kBent, 6000, random)) {
    all.add_patch(patch);
    (++i % 3 == 0 ? left : right).add_patch(patch);
  }
  left.add(right);
  FloatSurface one, merged;
  double one_square = 0, merged_square = 0;
  ASSERT_TRUE(all.solve(one, one_square));
  ASSERT_TRUE(left.solve(merged, merged_square));
  EXPECT_NEAR(merged_square, one_square, 1e-6 * one_square);
  EXPECT_NEAR(merged.at(0.05, 0.05), one.at(0.05, 0.05), 1e-3);
}

TEST(QuadricSums, RefuseWhatSpansNoSurface) {
  FloatSurface found;
  double mean_square = 0;
  QuadricSums sums;
  EXPECT_FALSE(sums.solve(found, mean_square));
  sums.add_patch({64, 0.1, 0.1, 1e6, 3e-5, 0, 3e-5, 0, 0, 1});
  EXPECT_FALSE(sums.solve(found, mean_square));
}

TEST(Cells, MeasureTheirDistanceFromAnySurface) {
  Cell cell;
  cell.n = 64;
  cell.x = 0.1F;
  cell.y = -0.05F;
  cell.w = 1.5e6F;
  cell.xx = cell.yy = 3e-5F;
  cell.a = 2e5F;
  cell.variance = 1e6F;
  cell.own = 2e6F;
  FloatSurface plane{2e5, 0, 0};
  plane.c = 1.5e6 - plane.a * 0.1;
  EXPECT_NEAR(cell_residual(cell, plane), 2, 1e-3);
  plane.c += 1000;
  EXPECT_NEAR(cell_residual(cell, plane), 3, 1e-2);
  plane.b = 1e6;  // turns about the cell's middle only when c follows
  plane.c += plane.b * 0.05;
  EXPECT_NEAR(cell_residual(cell, plane), 3 + 30, 0.1);
}

}  // namespace
}  // namespace planecast
