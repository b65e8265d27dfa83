#include "core/search/kdtree_search.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/base/random.hpp"

namespace planecast {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

std::vector<Point3f> random_points(std::size_t count, std::uint64_t seed, double scale = 5.0) {
  Pcg32 random(seed);
  std::vector<Point3f> points(count);
  for (Point3f& p : points) {
    p = {static_cast<float>(scale * (random.uniform() - 0.5)),
         static_cast<float>(scale * (random.uniform() - 0.5)),
         static_cast<float>(scale * random.uniform())};
  }
  return points;
}

/// Every point with its distance, nearest first, then lowest index: the answer by definition.
std::vector<Neighbour> brute_force(const std::vector<Point3f>& points, const Point3f& q) {
  std::vector<Neighbour> all;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double dx = double{q.x} - points[i].x;
    const double dy = double{q.y} - points[i].y;
    const double dz = double{q.z} - points[i].z;
    const double sq = dx * dx + dy * dy + dz * dz;
    if (std::isfinite(sq)) all.push_back({static_cast<std::uint32_t>(i), sq});
  }
  std::sort(all.begin(), all.end(), [](const Neighbour& a, const Neighbour& b) {
    return a.sq_dist != b.sq_dist ? a.sq_dist < b.sq_dist : a.index < b.index;
  });
  return all;
}

void expect_same_as_brute_force(const std::vector<Point3f>& points,
                                const std::vector<Point3f>& queries, std::size_t k) {
  const KdTreeSearch tree(points);
  std::vector<Neighbour> found(k);
  for (const Point3f& q : queries) {
    const std::vector<Neighbour> truth = brute_force(points, q);
    ASSERT_EQ(tree.knn(q, found), std::min(k, truth.size()));
    for (std::size_t i = 0; i < std::min(k, truth.size()); ++i) {
      ASSERT_EQ(found[i].index, truth[i].index) << "place " << i;
      ASSERT_EQ(found[i].sq_dist, truth[i].sq_dist) << "place " << i;
    }
    const Neighbour one = tree.nearest(q);
    ASSERT_EQ(one.index, truth.front().index);
    ASSERT_EQ(one.sq_dist, truth.front().sq_dist);
  }
}

TEST(KdTreeSearch, FindsWhatBruteForceFinds) {
  expect_same_as_brute_force(random_points(3000, 1), random_points(300, 2, 7.0), 16);
}

TEST(KdTreeSearch, FindsWhatBruteForceFindsFarFromTheOrigin) {
  std::vector<Point3f> points = random_points(1000, 3);
  std::vector<Point3f> queries = random_points(100, 4);
  for (Point3f& p : points) p.x += 50000.0F;
  for (Point3f& p : queries) p.x += 50000.0F;
  expect_same_as_brute_force(points, queries, 8);
}

TEST(KdTreeSearch, AmongEqualDistancesTheLowestIndexWins) {
  // A coarse lattice with every point several times: almost every answer is a tie.
  std::vector<Point3f> points;
  for (int copy = 0; copy < 5; ++copy) {
    for (int i = 0; i < 125; ++i) {
      points.push_back(
          {static_cast<float>(i % 5), static_cast<float>(i / 5 % 5), static_cast<float>(i / 25)});
    }
  }
  expect_same_as_brute_force(points, points, 9);
}

TEST(KdTreeSearch, LeavesOutPointsThatAreNotFiniteAndKeepsTheCallersIndices) {
  std::vector<Point3f> points = random_points(500, 5);
  for (std::size_t i = 0; i < points.size(); i += 3) points[i].y = kNaN;
  points[1].x = std::numeric_limits<float>::infinity();
  const KdTreeSearch tree(points);
  EXPECT_EQ(tree.size(), 500U - 167U - 1U);
  expect_same_as_brute_force(points, random_points(50, 6), 4);
}

TEST(KdTreeSearch, FindsAllPointsWhenFewerThanK) {
  expect_same_as_brute_force(random_points(3, 7), random_points(5, 8), 10);
}

TEST(KdTreeSearch, AnEmptyTreeFindsNothing) {
  const std::vector<Point3f> none;
  const std::vector<Point3f> invalid(4, Point3f{kNaN, 0, 0});
  std::vector<Neighbour> found(2);
  for (const auto& points : {none, invalid}) {
    const KdTreeSearch tree(points);
    EXPECT_EQ(tree.size(), 0U);
    EXPECT_FALSE(tree.nearest({0, 0, 0}).found());
    EXPECT_EQ(tree.nearest({0, 0, 0}).sq_dist, std::numeric_limits<double>::infinity());
    EXPECT_EQ(tree.knn({0, 0, 0}, found), 0U);
  }
}

TEST(KdTreeSearch, AQueryThatIsNotFiniteFindsNothing) {
  const KdTreeSearch tree(random_points(10, 9));
  EXPECT_FALSE(tree.nearest({0, kNaN, 0}).found());
}

TEST(KdTreeSearch, OutlivesThePointsItWasBuiltFrom) {
  std::vector<Point3f> points = random_points(200, 10);
  const Point3f query = points[42];
  KdTreeSearch tree(points);
  points.assign(points.size(), Point3f{});
  const KdTreeSearch moved = std::move(tree);
  EXPECT_EQ(moved.nearest(query).index, 42U);
  EXPECT_EQ(moved.nearest(query).sq_dist, 0.0);
}

}  // namespace
}  // namespace planecast
