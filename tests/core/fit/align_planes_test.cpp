// Planes turn to the directions of better known ones as far as noise may have turned them, and no
// further.
#include "core/fit/align_planes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/base/random.hpp"
#include "core/fit/region_refine.hpp"

namespace planecast {
namespace {

constexpr double kDegrees = 180 / 3.14159265358979323846;
constexpr std::uint32_t kWide = 60;

// Regions of cells in a row of squares, each of its own plane with noise of one sigma a cell.
struct Scene {
  std::vector<Cell> cells;
  std::vector<std::uint8_t> labels;
  RegionMap map;
  std::vector<RegionFit> fits = std::vector<RegionFit>(kMaxSurfaces);
  Pcg32 random{5};

  // A square of `side` cells of the plane (a, b, c), seen at rays around x.
  void add(double a, double b, double c, std::uint32_t side, double sigma) {
    const auto label = static_cast<std::uint8_t>(++map.regions);
    PlaneSums sums;
    for (std::uint32_t i = 0; i < side * side; ++i) {
      Cell cell;
      cell.n = 16;
      cell.x = static_cast<float>(0.01 * (i % side) + 0.1 * label - 0.3);
      cell.y = static_cast<float>(0.01 * (i / side));
      cell.xx = cell.yy = 1e-5F;
      double gauss = -6;
      for (int k = 0; k < 12; ++k) gauss += random.uniform();
      cell.w = static_cast<float>(a * double{cell.x} + b * double{cell.y} + c + sigma * gauss);
      cell.a = static_cast<float>(a);
      cell.b = static_cast<float>(b);
      cell.variance = static_cast<float>(sigma * sigma);
      cell.usable = true;
      cells.push_back(cell);
      labels.push_back(label);
      sums.add(plane_sums(cell));
    }
    fits[label - 1U].valid = sums.solve(fits[label - 1U].surface);
  }
  int align() {
    map.cells_wide = kWide;
    map.cells_high = static_cast<std::uint32_t>(cells.size() / kWide);
    map.cells = cells;
    map.labels = labels;
    return align_planes(map, fits);
  }
  double angle(int region, double a, double b, double c) const {
    const FloatSurface& s = fits[region - 1].surface;
    const double dot = s.a * a + s.b * b + s.c * c;
    return kDegrees * std::acos(std::min(1.0, dot / std::sqrt((s.a * s.a + s.b * s.b + s.c * s.c) *
                                                              (a * a + b * b + c * c))));
  }
};

TEST(AlignPlanes, TurnsASmallFaceParallelToAWall) {
  Scene scene;
  scene.add(2e5, 1e5, 1e6, 60, 300);
  scene.add(2.4e5, 1.2e5, 1.2e6, 6, 3000);  // the same direction, a little nearer
  EXPECT_EQ(scene.align(), 1);
  EXPECT_LT(scene.angle(2, 2, 1, 10), 0.1);
  EXPECT_LT(scene.angle(1, 2, 1, 10), 0.1);
}

TEST(AlignPlanes, TurnsASmallFaceAtRightAnglesToTwoWalls) {
  Scene scene;
  scene.add(1e6, 0, 1e6, 60, 300);
  scene.add(-1e6, 0, 1e6, 60, 300);
  scene.add(0, 1e6, 0, 6, 4000);
  const double before = scene.angle(3, 0, 1, 0);
  ASSERT_GT(before, 0.5);
  EXPECT_GE(scene.align(), 1);
  EXPECT_LT(scene.angle(3, 0, 1, 0), 0.2);
}

TEST(AlignPlanes, LeavesAFaceAloneThatIsClearlyAskew) {
  Scene scene;
  scene.add(2e5, 1e5, 1e6, 60, 300);
  scene.add(4e5, 1e5, 1e6, 20, 1000);  // eleven degrees off
  const FloatSurface before = scene.fits[1].surface;
  EXPECT_EQ(scene.align(), 0);
  EXPECT_EQ(scene.fits[1].surface.a, before.a);
  EXPECT_EQ(scene.fits[1].surface.c, before.c);
}

TEST(AlignPlanes, NeverTurnsWhatIsKnownWell) {
  Scene scene;
  scene.add(2e5, 1e5, 1e6, 60, 300);
  scene.add(2.01e5, 1e5, 1e6, 60, 300);
  EXPECT_EQ(scene.align(), 0);
}

}  // namespace
}  // namespace planecast
