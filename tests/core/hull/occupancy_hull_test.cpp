// Boundaries of planes' points: every point inside, holes and islands kept, and close to the alpha
// hull by its definition (a place is outside when an empty disc of radius alpha covers it).
#include "core/hull/occupancy_hull.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "core/base/random.hpp"

namespace planecast {
namespace {

constexpr double kUnit = 0.02 / 256;  // cells of 20 mm

struct Scene {
  std::vector<float> x, y, z;
  std::vector<std::uint32_t> members;
  PointPlane plane;
  std::vector<DraftCell> cells;
  std::vector<PatchDraft> drafts;
  HullOutput output;
  std::uint32_t kept = 0;

  /// Points of the unit square that `inside` accepts, `spacing` apart, on z = 0.3 x + 1.
  Scene(double spacing, const std::function<bool(double, double)>& inside) {
    const auto steps = static_cast<int>(1 / spacing);
    for (int j = 0; j < steps; ++j) {
      for (int i = 0; i < steps; ++i) {
        const double u = (i + 0.5) * spacing, v = (j + 0.5) * spacing;
        if (inside(u, v)) add(u, v, 0.3 * u + 1);
      }
    }
    const double length = std::sqrt(0.09 + 1);
    plane = {
        0.3 / length, 0, -1 / length, 1 / length, 0, 0, static_cast<std::uint32_t>(members.size())};
  }

  void add(double a, double b, double c) {
    x.push_back(static_cast<float>(a));
    y.push_back(static_cast<float>(b));
    z.push_back(static_cast<float>(c));
    members.push_back(static_cast<std::uint32_t>(members.size()));
  }

  Status make(const HullOptions& options = {}) {
    const auto n = static_cast<std::uint32_t>(members.size());
    cells.assign(hull_cells(n, 1, options), {});
    drafts.assign(hull_drafts(n, 1, options), {});
    output = {cells, drafts};
    return make_hulls(plane, members, {x, y, z}, kUnit, options, output, kept);
  }

  /// True when a draft has the place (of x, y) inside.
  bool covers(double u, double v) const {
    for (std::uint32_t n = 0; n < output.drafts_used; ++n) {
      const PatchDraft& d = drafts[n];
      const double side = kUnit * (1U << d.pitch_log2);
      const auto i = static_cast<std::int64_t>(std::floor(u / side)) - d.cell_u;
      const auto j = static_cast<std::int64_t>(std::floor(v / side)) - d.cell_v;
      if (i < 0 || j < 0 || i >= d.wide || j >= d.high) continue;
      if (cells[d.first_cell + static_cast<std::size_t>(j * d.wide + i)].inside()) return true;
    }
    return false;
  }

  std::uint32_t draft_points() const {
    std::uint32_t points = 0;
    for (std::uint32_t n = 0; n < output.drafts_used; ++n) points += drafts[n].points;
    return points;
  }
};

bool in_l(double u, double v) {
  return u < 0.3 || v < 0.3;
}
bool in_ring(double u, double v) {
  const double r = std::hypot(u - 0.5, v - 0.5);
  return r > 0.25 && r < 0.48;
}
bool in_islands(double u, double v) {
  return std::hypot(u - 0.2, v - 0.2) < 0.15 || std::hypot(u - 0.75, v - 0.75) < 0.2;
}

class HullShapes : public ::testing::TestWithParam<bool (*)(double, double)> {};

TEST_P(HullShapes, EveryPointIsInsideAndHolesStayOpen) {
  Scene scene(0.008, GetParam());
  ASSERT_EQ(scene.make(), Status::kOk);
  EXPECT_EQ(scene.kept, scene.members.size());
  EXPECT_EQ(scene.draft_points(), scene.kept);
  for (const std::uint32_t m : scene.members) ASSERT_TRUE(scene.covers(scene.x[m], scene.y[m]));
  // What is farther than a closed corner from the shape is outside, holes and bays included.
  for (double v = 0.005; v < 1; v += 0.01) {
    for (double u = 0.005; u < 1; u += 0.01) {
      bool near = false;
      for (double a = 0; a < 6.28; a += 0.3) {
        near |= GetParam()(u + 0.057 * std::cos(a), v + 0.057 * std::sin(a)) ||
                GetParam()(u + 0.03 * std::cos(a), v + 0.03 * std::sin(a));
      }
      if (!near && !GetParam()(u, v)) ASSERT_FALSE(scene.covers(u, v)) << u << ", " << v;
    }
  }
}

TEST_P(HullShapes, AgreesWithTheAlphaHullByDefinition) {
  constexpr double kAlpha = 0.02;
  Scene scene(0.01, GetParam());
  ASSERT_EQ(scene.make(), Status::kOk);
  // Places where an open disc of radius alpha is empty, then all that such discs cover.
  constexpr int kSide = 220;
  constexpr double kStep = 1.1 / kSide;
  std::vector<bool> empty(kSide * kSide, true), outside(kSide * kSide, false);
  const auto mark = [&](double u, double v, std::vector<bool>& field, bool value) {
    const int reach = static_cast<int>(kAlpha / kStep) + 1;
    const int ci = static_cast<int>((u + 0.05) / kStep), cj = static_cast<int>((v + 0.05) / kStep);
    for (int j = std::max(0, cj - reach); j <= std::min(kSide - 1, cj + reach); ++j) {
      for (int i = std::max(0, ci - reach); i <= std::min(kSide - 1, ci + reach); ++i) {
        if (std::hypot(i * kStep - 0.05 - u, j * kStep - 0.05 - v) < kAlpha)
          field[static_cast<std::size_t>(j * kSide + i)] = value;
      }
    }
  };
  for (const std::uint32_t m : scene.members) mark(scene.x[m], scene.y[m], empty, false);
  for (int n = 0; n < kSide * kSide; ++n) {
    if (empty[static_cast<std::size_t>(n)])
      mark(n % kSide * kStep - 0.05, n / kSide * kStep - 0.05, outside, true);
  }
  int alpha_area = 0, own_area = 0, alpha_only = 0;
  for (int n = 0; n < kSide * kSide; ++n) {
    const bool alpha = !outside[static_cast<std::size_t>(n)];
    const bool own = scene.covers(n % kSide * kStep - 0.05, n / kSide * kStep - 0.05);
    alpha_area += alpha ? 1 : 0;
    own_area += own ? 1 : 0;
    alpha_only += alpha && !own ? 1 : 0;
  }
  EXPECT_LT(alpha_only, alpha_area / 100) << "the alpha hull is covered";
  // Larger by a strip as wide as half a cell along the outline, at most a cell.
  EXPECT_LT(own_area * kStep * kStep, alpha_area * kStep * kStep + 4.6 * 0.02);
}

INSTANTIATE_TEST_SUITE_P(Shapes, HullShapes, ::testing::Values(in_l, in_ring, in_islands));

TEST(OccupancyHull, TheSurfaceIsThePlane) {
  Scene scene(0.02, in_l);
  ASSERT_EQ(scene.make(), Status::kOk);
  const PatchDraft& d = scene.drafts[0];
  ASSERT_EQ(d.axis, 2);
  for (const std::uint32_t m : scene.members) {
    const double height =
        d.coefficients[0] * kUnit + d.coefficients[1] * scene.x[m] + d.coefficients[2] * scene.y[m];
    ASSERT_NEAR(height, scene.z[m], 1e-6);
  }
}

TEST(OccupancyHull, AThinStripAcrossTwoAxesDropsTheOneItsNormalPointsAlong) {
  // Least variance is along z, but z does not follow from x and y on this plane.
  Scene scene(0.5, [](double, double) { return false; });
  for (int i = 0; i < 2000; ++i) {
    const double t = 0.001 * i;
    scene.add(0.8 * t, -0.6 * t, 0.01 * (i % 5));
  }
  scene.plane = {0.6, 0.8, 0, 0, 0, 0, 2000};
  ASSERT_EQ(scene.make(), Status::kOk);
  EXPECT_EQ(scene.drafts[0].axis, 1);
  EXPECT_EQ(scene.kept, 2000U);
}

TEST(OccupancyHull, FarIslandsAndDiagonalsAreCutIntoPartsOfFineCells) {
  Scene scene(0.5, [](double, double) { return false; });
  for (int i = 0; i < 4000; ++i) scene.add(0.005 * i, 0.005 * i + 0.002 * (i % 7), 1);
  scene.plane = {0, 0, 1, -1, 0, 0, 4000};
  ASSERT_EQ(scene.make(), Status::kOk);
  EXPECT_GT(scene.output.drafts_used, 4U);
  EXPECT_GT(scene.kept, 3900U);
  EXPECT_EQ(scene.draft_points(), scene.kept);
  for (std::uint32_t n = 0; n < scene.output.drafts_used; ++n)
    EXPECT_LE(scene.drafts[n].pitch_log2, 9);
  for (std::uint32_t n = 0; n < scene.kept; ++n) {
    const std::uint32_t m = scene.members[n];
    ASSERT_TRUE(scene.covers(scene.x[m], scene.y[m]));
  }
}

TEST(OccupancyHull, LonelyPointsAreLeftOutAndStandLast) {
  Scene scene(0.01, in_l);
  scene.add(3, 3, 1.9);
  scene.add(0.9, 0.9, 1.27);
  const auto n = static_cast<std::uint32_t>(scene.members.size());
  ASSERT_EQ(scene.make(), Status::kOk);
  EXPECT_EQ(scene.kept, n - 2);
  std::vector<std::uint32_t> last(scene.members.end() - 2, scene.members.end());
  std::sort(last.begin(), last.end());
  EXPECT_EQ(last, (std::vector<std::uint32_t>{n - 2, n - 1}));
  EXPECT_EQ(scene.draft_points(), scene.kept);
}

TEST(OccupancyHull, SparsePointsGetWiderCells) {
  for (const double spacing : {0.03, 0.05, 0.08}) {  // with cells of 0.02
    Scene scene(spacing, [](double, double) { return true; });
    ASSERT_EQ(scene.make(), Status::kOk);
    ASSERT_EQ(scene.output.drafts_used, 1U);
    EXPECT_GE(scene.drafts[0].pitch_log2, kAlphaPitchLog2 + 1);
    EXPECT_EQ(scene.kept, scene.members.size());
  }
}

TEST(OccupancyHull, APlaneTooWideForTheWidestCellsIsCut) {
  Scene scene(0.5, [](double, double) { return false; });
  for (int i = 0; i < 2500; ++i) scene.add(600.0 * (i % 50), 600.0 * (i / 50), 1);  // 30 km
  for (int i = 0; i < 400; ++i) scene.add(0.01 * (i % 20), 0.01 * (i / 20), 1);
  scene.plane = {0, 0, 1, -1, 0, 0, 2900};
  ASSERT_EQ(scene.make(), Status::kOk);
  EXPECT_GE(scene.kept, 400U);
  EXPECT_EQ(scene.draft_points(), scene.kept);
}

TEST(OccupancyHull, PilesOnePointAndFarPointsGiveAResultOrAStatus) {
  Scene pile(0.5, [](double, double) { return false; });
  for (int i = 0; i < 100; ++i) pile.add(1, 2, 3);
  pile.plane = {0, 0, 1, -3, 0, 0, 100};
  ASSERT_EQ(pile.make(), Status::kOk);
  EXPECT_EQ(pile.kept, 100U);
  Scene one(0.5, [](double, double) { return false; });
  one.add(1, 2, 3);
  one.plane = {0, 0, 1, -3, 0, 0, 1};
  ASSERT_EQ(one.make(), Status::kOk);
  EXPECT_EQ(one.kept, 1U);
  one.x[0] = 1e30F;
  EXPECT_EQ(one.make(), Status::kFieldRange);
  one.members.clear();
  EXPECT_EQ(one.make(), Status::kOk);
  HullOptions options;
  options.least_points = 1;
  EXPECT_EQ(one.make(options), Status::kBadConfig);
}

}  // namespace
}  // namespace planecast
