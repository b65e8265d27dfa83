// Our practical hull and the alpha shape of the benchmarks beside the hulls of CGAL and PCL, where
// these are installed: the same corners and area for the alpha shape, every point inside and the
// area that its definition allows for the cells.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "bench/alpha_shape.hpp"
#include "bench/pcl_chain.hpp"
#include "core/base/random.hpp"
#include "core/hull/occupancy_hull.hpp"

#ifdef PLANECAST_HAVE_CGAL
#include <CGAL/Alpha_shape_2.h>
#include <CGAL/Alpha_shape_face_base_2.h>
#include <CGAL/Alpha_shape_vertex_base_2.h>
#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#endif

namespace planecast::bench {
namespace {

using baselines::PointList;
using Shape = std::function<bool(double, double)>;

constexpr double kAlpha_m = 0.04;

// Points at random places of the unit square that `inside` accepts, on z = 0.
PointList points_in(const Shape& inside) {
  PointList points;
  Pcg32 random(11);
  while (points.size() < 8000) {
    const double u = random.uniform(), v = random.uniform();
    if (inside(u, v)) points.push_back({static_cast<float>(u), static_cast<float>(v), 0});
  }
  return points;
}

bool in_l(double u, double v) {
  return u < 0.3 || v < 0.3;
}
bool in_ring(double u, double v) {
  const double r = std::hypot(u - 0.5, v - 0.5);
  return r > 0.25 && r < 0.48;
}
bool in_islands(double u, double v) {
  return std::hypot(u - 0.2, v - 0.2) < 0.15 || std::hypot(u - 0.7, v - 0.7) < 0.25;
}

class HullPeers : public testing::TestWithParam<bool (*)(double, double)> {};
INSTANTIATE_TEST_SUITE_P(Shapes, HullPeers, testing::Values(in_l, in_ring, in_islands));

TEST_P(HullPeers, TheAlphaShapeHasTheCornersOfPcls) {
  if (!pcl_available()) GTEST_SKIP() << "PCL: libpcl-dev is not installed";
  const PointList points = points_in(GetParam());
  const AlphaShape own = alpha_shape(points, {0, 0, 1}, kAlpha_m);
  EXPECT_GT(own.corners, 50U);
  // PCL triangulates in float.
  EXPECT_NEAR(static_cast<double>(own.corners),
              static_cast<double>(pcl_hull_corners(points, kAlpha_m)), 4);
}

#ifdef PLANECAST_HAVE_CGAL
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Vertex = CGAL::Alpha_shape_vertex_base_2<Kernel>;
using Face = CGAL::Alpha_shape_face_base_2<Kernel>;
using Mesh =
    CGAL::Delaunay_triangulation_2<Kernel, CGAL::Triangulation_data_structure_2<Vertex, Face>>;
using CgalShape = CGAL::Alpha_shape_2<Mesh>;

AlphaShape cgal_shape(const PointList& points, double alpha_m) {
  std::vector<Kernel::Point_2> flat;
  for (const Point3f& p : points) flat.emplace_back(p.x, p.y);
  const CgalShape shape(flat.begin(), flat.end(), alpha_m * alpha_m, CgalShape::REGULARIZED);
  AlphaShape found;
  for (auto face = shape.finite_faces_begin(); face != shape.finite_faces_end(); ++face) {
    if (shape.classify(face) == CgalShape::INTERIOR)
      found.area_m2 += CGAL::to_double(shape.triangle(face).area());
  }
  for (auto edge = shape.alpha_shape_edges_begin(); edge != shape.alpha_shape_edges_end(); ++edge)
    ++found.corners;
  return found;
}

TEST_P(HullPeers, TheAlphaShapeIsCgals) {
  const PointList points = points_in(GetParam());
  const AlphaShape own = alpha_shape(points, {0, 0, 1}, kAlpha_m);
  const AlphaShape theirs = cgal_shape(points, kAlpha_m);
  EXPECT_EQ(own.corners, theirs.corners);
  EXPECT_NEAR(own.area_m2, theirs.area_m2, 1e-5);
}
#endif

TEST_P(HullPeers, TheCellsHoldEveryPointAndTheAreaOfTheAlphaShapeAndHalfACellAround) {
  const PointList points = points_in(GetParam());
  const double pitch = kAlpha_m / 2, unit = pitch / (1U << kAlphaPitchLog2);
  std::vector<float> x, y, z(points.size());
  std::vector<std::uint32_t> members;
  for (const Point3f& p : points) {
    members.push_back(static_cast<std::uint32_t>(members.size()));
    x.push_back(p.x);
    y.push_back(p.y);
  }
  const auto n = static_cast<std::uint32_t>(points.size());
  std::vector<DraftCell> cells(hull_cells(n, 1, {}));
  std::vector<PatchDraft> drafts(hull_drafts(n, 1, {}));
  HullOutput output{cells, drafts};
  PointPlane plane;
  plane.count = n;
  std::uint32_t kept = 0;
  ASSERT_EQ(make_hulls(plane, members, {x, y, z}, unit, {}, output, kept), Status::kOk);
  EXPECT_EQ(kept, n);
  double area = 0;
  std::uint32_t held = 0;
  for (const PatchDraft& d : std::span(drafts).first(output.drafts_used)) {
    const double side = unit * (1U << d.pitch_log2);
    for (const DraftCell& cell : std::span(cells).subspan(d.first_cell, d.wide * d.high))
      area += cell.inside() ? side * side : 0;
    held += d.points;
  }
  EXPECT_EQ(held, n);
  const AlphaShape alpha = alpha_shape(points, {0, 0, 1}, pitch);
#ifdef PLANECAST_HAVE_CGAL
  EXPECT_NEAR(alpha.area_m2, cgal_shape(points, pitch).area_m2, 1e-5);
#endif
  // Outlines of at most 6 m, half a cell on average outside of the points.
  EXPECT_GT(area, alpha.area_m2);
  EXPECT_LT(area, alpha.area_m2 + 6 * pitch / 2);
}

TEST(AlphaShape, OfASquareOfPointsIsTheSquareAndItsRim) {
  PointList points;
  for (int j = 0; j <= 20; ++j) {
    for (int i = 0; i <= 20; ++i) {
      const auto u = static_cast<float>(0.05 * i), v = static_cast<float>(0.05 * j);
      points.push_back({u, v, 0.2F * u});
    }
  }
  const double down = std::sqrt(1.04);
  const AlphaShape shape = alpha_shape(points, {0.2 / down, 0, -1 / down}, 0.06);
  EXPECT_EQ(shape.corners, 80U);
  EXPECT_NEAR(shape.area_m2, down, 1e-4);
  EXPECT_EQ(alpha_shape(points, {0.2 / down, 0, -1 / down}, 0.03).corners, 0U);
}

TEST(AlphaShape, OfTooFewPointsIsNothing) {
  EXPECT_EQ(alpha_shape({}, {0, 0, 1}, 1).corners, 0U);
  EXPECT_EQ(alpha_shape({{1, 2, 3}, {2, 2, 3}}, {0, 0, 1}, 1).corners, 0U);
}

}  // namespace
}  // namespace planecast::bench
