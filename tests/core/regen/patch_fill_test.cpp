// Points regenerated from patches: as many as asked, inside the cells, on the surface, the same
// again.
#include "core/regen/patch_fill.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace planecast {
namespace {

/// A ring of cells: a square with a hole in it, tilted, away from the origin.
struct Ring {
  Patch patch;
  std::vector<std::uint8_t> cells;

  explicit Ring(std::uint32_t points, std::uint32_t side = 24, unsigned pitch_log2 = 8) {
    patch.axis = 1;
    patch.pitch_log2 = static_cast<std::uint8_t>(pitch_log2);
    patch.height_log2 = 2;
    patch.cell_u = -7;
    patch.cell_v = 40;
    patch.wide = patch.high = side;
    patch.points = points;
    patch.coefficients = {5000, 300, -200, 0, 0, 0};
    for (std::uint32_t j = 0; j < side; ++j) {
      for (std::uint32_t i = 0; i < side; ++i) {
        const bool hole = i >= side / 3 && i < 2 * side / 3 && j >= side / 3 && j < 2 * side / 3;
        cells.push_back(hole ? 0 : 1);
      }
    }
  }
};

class PatchFillTest : public ::testing::TestWithParam<FillMode> {
 protected:
  PatchFillTest() : arena_(std::move(Arena::map(std::size_t{1} << 19U).value())) {
    filler_.layout(arena_);
    stream_.patch_unit_nm = 78125;
    stream_.fill = GetParam();
  }

  std::vector<Point3f> fill(const Ring& ring, std::uint32_t seed = 1) {
    stream_.seed = seed;
    std::vector<Point3f> out(ring.patch.points);
    Pcg32 generator = patch_generator(stream_, 3, 4);
    EXPECT_EQ(filler_.fill(ring.patch, ring.cells, stream_, generator, out), Status::kOk);
    return out;
  }

  /// Cell of a point, or none when it lies outside the patch's grid.
  static std::int64_t cell_of(const Patch& patch, double u, double v) {
    const double side = std::ldexp(1.0, patch.pitch_log2);
    const auto i = static_cast<std::int64_t>(std::floor(u / side)) - patch.cell_u;
    const auto j = static_cast<std::int64_t>(std::floor(v / side)) - patch.cell_v;
    if (i < 0 || j < 0 || i >= patch.wide || j >= patch.high) return -1;
    return j * patch.wide + i;
  }

  Arena arena_;
  PatchFiller filler_;
  PointStream stream_;
};

TEST_P(PatchFillTest, PointsLieInTheirCellsAndOnTheSurface) {
  for (const std::uint32_t points : {1U, 2U, 7U, 100U, 5000U}) {
    const Ring ring(points);
    const PatchSurface surface(ring.patch);
    for (const Point3f& p : fill(ring)) {
      const double unit = patch_unit_m(stream_);
      const double u = std::nearbyint(p.x / unit), v = std::nearbyint(p.z / unit);
      const std::int64_t cell = cell_of(ring.patch, u + 0.25, v + 0.25);
      ASSERT_GE(cell, 0);
      ASSERT_NE(ring.cells[static_cast<std::size_t>(cell)], 0) << "in the hole";
      const std::int64_t height =
          surface.height(static_cast<std::int64_t>(u), static_cast<std::int64_t>(v));
      ASSERT_NEAR(p.y, static_cast<double>(height) * unit, 1e-6);
    }
  }
}

TEST_P(PatchFillTest, EveryPartOfTheAreaGetsItsShare) {
  const Ring ring(20000);
  std::vector<int> counts(ring.cells.size());
  for (const Point3f& p : fill(ring)) {
    const double unit = patch_unit_m(stream_);
    ++counts[static_cast<std::size_t>(
        cell_of(ring.patch, std::nearbyint(p.x / unit) + 0.25, std::nearbyint(p.z / unit) + 0.25))];
  }
  const double mean = 20000.0 / (24 * 24 - 8 * 8);
  // Five standard deviations of a fair draw; the lattice stays within its row's rounding.
  const double allowed = GetParam() == FillMode::kRandom ? 5 * std::sqrt(mean) : 0.3 * mean;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (ring.cells[i] != 0) {
      ASSERT_NEAR(counts[i], mean, allowed) << "cell " << i;
    }
  }
}

TEST_P(PatchFillTest, TheSameSeedGivesTheSamePoints) {
  const Ring ring(500);
  const auto same = [](const Point3f& a, const Point3f& b) {
    return a.x == b.x && a.y == b.y && a.z == b.z;
  };
  const auto first = fill(ring, 9), again = fill(ring, 9), other = fill(ring, 10);
  EXPECT_TRUE(std::equal(first.begin(), first.end(), again.begin(), same));
  EXPECT_EQ(std::equal(first.begin(), first.end(), other.begin(), same),
            GetParam() == FillMode::kLattice);
}

TEST_P(PatchFillTest, CellsOfOneStepWork) {
  const Ring ring(64, 24, 0);
  EXPECT_EQ(fill(ring).size(), 64U);
}

TEST_P(PatchFillTest, RefusesSizesThatDisagreeAndPatchesWithoutACell) {
  Ring ring(10);
  std::vector<Point3f> out(9);
  Pcg32 generator = patch_generator(stream_, 0, 0);
  EXPECT_EQ(filler_.fill(ring.patch, ring.cells, stream_, generator, out), Status::kWrongSize);
  out.resize(10);
  std::fill(ring.cells.begin(), ring.cells.end(), std::uint8_t{0});
  EXPECT_EQ(filler_.fill(ring.patch, ring.cells, stream_, generator, out), Status::kFieldRange);
  ring.cells.pop_back();
  EXPECT_EQ(filler_.fill(ring.patch, ring.cells, stream_, generator, out), Status::kWrongSize);
  ring.patch.wide = 0;
  EXPECT_EQ(filler_.fill(ring.patch, ring.cells, stream_, generator, out), Status::kFieldRange);
}

INSTANTIATE_TEST_SUITE_P(Both, PatchFillTest,
                         ::testing::Values(FillMode::kLattice, FillMode::kRandom));

TEST(PatchFill, ALatticeIsAsEvenAsItsSpacingSays) {
  Arena arena = std::move(Arena::map(std::size_t{1} << 19U).value());
  PatchFiller filler;
  filler.layout(arena);
  PointStream stream;
  stream.patch_unit_nm = 78125;
  Ring ring(400);
  std::fill(ring.cells.begin(), ring.cells.end(), std::uint8_t{1});
  std::vector<Point3f> out(400);
  Pcg32 generator = patch_generator(stream, 0, 0);
  ASSERT_EQ(filler.fill(ring.patch, ring.cells, stream, generator, out), Status::kOk);
  const double spacing = std::sqrt(24.0 * 24 / 400) * 0.02;  // of cells of 20 mm
  for (std::size_t i = 0; i < out.size(); ++i) {
    double nearest = 1;
    for (std::size_t k = 0; k < out.size(); ++k) {
      if (k != i)
        nearest = std::min<double>(nearest, std::hypot(out[i].x - out[k].x, out[i].z - out[k].z));
    }
    EXPECT_GT(nearest, 0.6 * spacing);
    EXPECT_LT(nearest, 1.3 * spacing);
  }
}

TEST(PatchFill, RandomPointsAreThoseOfTheDocumentedGenerator) {
  // Frozen: other machines and later versions must give these very points.
  Arena arena = std::move(Arena::map(std::size_t{1} << 19U).value());
  PatchFiller filler;
  filler.layout(arena);
  PointStream stream;
  stream.patch_unit_nm = 78125;
  stream.fill = FillMode::kRandom;
  const Ring ring(3);
  std::vector<Point3f> out(3);
  Pcg32 generator = patch_generator(stream, 3, 4), copy = generator;
  ASSERT_EQ(filler.fill(ring.patch, ring.cells, stream, generator, out), Status::kOk);
  const std::uint32_t inside = 24 * 24 - 8 * 8;
  std::vector<std::uint32_t> numbers;
  for (std::uint32_t i = 0; i < ring.cells.size(); ++i) {
    if (ring.cells[i] != 0) numbers.push_back(i);
  }
  for (const Point3f& p : out) {
    const std::uint32_t cell = numbers[copy.below(inside)];
    const std::int64_t u = (-7 + static_cast<std::int64_t>(cell % 24)) * 256 + (copy.next() >> 24U);
    const std::int64_t v = (40 + static_cast<std::int64_t>(cell / 24)) * 256 + (copy.next() >> 24U);
    EXPECT_EQ(p.x, static_cast<float>(static_cast<double>(u) * 78125e-9));
    EXPECT_EQ(p.z, static_cast<float>(static_cast<double>(v) * 78125e-9));
  }
}

}  // namespace
}  // namespace planecast
