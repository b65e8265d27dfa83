// The triangulation under two baselines: no point in any circle, nothing left uncovered.
#include "bench/baselines/delaunay.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/random.hpp"

namespace planecast::baselines {
namespace {

std::vector<Point2i> random_points(std::uint64_t seed, int count, std::uint32_t side) {
  std::vector<Point2i> points;
  Pcg32 random(seed);
  for (int i = 0; i < count; ++i) {
    points.push_back({static_cast<std::int64_t>(random.next() % side),
                      static_cast<std::int64_t>(random.next() % side)});
  }
  return points;
}

double twice_area(const Point2i& a, const Point2i& b, const Point2i& c) {
  return static_cast<double>((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x));
}

// Centre and squared radius of the circle through three points.
struct Circle {
  Circle(const Point2i& a, const Point2i& b, const Point2i& c) {
    const double bx = double(b.x - a.x), by = double(b.y - a.y);
    const double cx = double(c.x - a.x), cy = double(c.y - a.y);
    const double d = 2 * (bx * cy - by * cx), b2 = bx * bx + by * by, c2 = cx * cx + cy * cy;
    x = (cy * b2 - by * c2) / d;
    y = (bx * c2 - cx * b2) / d;
    square = x * x + y * y;
    x += double(a.x);
    y += double(a.y);
  }
  double x, y, square;
};

TEST(Delaunay, NoPointLiesInTheCircleOfAnyTriangle) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    // Small sides: many points on common circles and lines, and equal ones.
    const auto points = random_points(seed, 120, seed % 2 == 0 ? 12 : 100000);
    const Delaunay mesh(points);
    ASSERT_FALSE(mesh.triangles().empty());
    for (const auto& t : mesh.triangles()) {
      ASSERT_GT(twice_area(points[t[0]], points[t[1]], points[t[2]]), 0);
      const Circle circle(points[t[0]], points[t[1]], points[t[2]]);
      for (const Point2i& p : points) {
        const double dx = double(p.x) - circle.x, dy = double(p.y) - circle.y;
        ASSERT_GE(dx * dx + dy * dy, circle.square * (1 - 1e-6));
      }
    }
  }
}

TEST(Delaunay, TrianglesCoverASquareOnceAndHoldWhatIsFoundInThem) {
  auto points = random_points(4, 200, 1000);
  for (const std::int64_t x : {0, 1000}) {
    for (const std::int64_t y : {0, 1000}) points.push_back({x, y});
  }
  Delaunay mesh(points);
  double area = 0;
  for (const auto& t : mesh.triangles())
    area += twice_area(points[t[0]], points[t[1]], points[t[2]]);
  EXPECT_EQ(area, 2e6);
  for (const Point2i& p : random_points(9, 500, 1000)) {
    const int found = mesh.find(p);
    ASSERT_GE(found, 0);
    const auto& t = mesh.triangles()[static_cast<std::size_t>(found)];
    for (int i = 0; i < 3; ++i) EXPECT_GE(twice_area(points[t[i]], points[t[(i + 1) % 3]], p), 0);
  }
}

TEST(Delaunay, PointsOnALineOrTooFewHaveNoTriangles) {
  EXPECT_TRUE(Delaunay({}).triangles().empty());
  EXPECT_TRUE(Delaunay({{5, 5}}).triangles().empty());
  EXPECT_TRUE(Delaunay({{0, 0}, {1, 1}, {2, 2}, {7, 7}, {2, 2}}).triangles().empty());
  EXPECT_EQ(Delaunay({{0, 0}}).find({3, 3}), -1);
}

}  // namespace
}  // namespace planecast::baselines
