// All nearest neighbours at once against brute force and against nanoflann.
#include "core/search/point_neighbours.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/random.hpp"
#include "core/search/kdtree_search.hpp"
#include "tests/support/sanitized.hpp"

namespace planecast {
namespace {

constexpr std::uint32_t kMostPoints = 60000;
constexpr std::uint32_t kMostNeighbours = 40;

class PointNeighboursTest : public ::testing::Test {
 protected:
  PointNeighboursTest() {
    Arena measure = Arena::measuring();
    search_.layout(measure, kMostPoints, kMostNeighbours);
    arena_ = std::move(Arena::map(measure.bytes_needed()).value());
    search_.layout(arena_, kMostPoints, kMostNeighbours);
  }

  /// Distances of every point's neighbours, sorted, against the definition.
  void expect_as_brute_force(const std::vector<Point3f>& points, std::uint32_t k) {
    ASSERT_EQ(search_.search(points, k, 1e9F), Status::kOk);
    const std::uint32_t n = search_.size();
    const std::uint32_t found = search_.neighbours();
    ASSERT_EQ(found, n == 0 ? 0 : std::min(k, n - 1));
    for (std::uint32_t i = 0; i < n; ++i) {
      std::vector<float> truth = distances_from(i);
      std::sort(truth.begin(), truth.end());
      std::vector<float> here;
      std::vector<std::uint32_t> ids(search_.of(i).begin(), search_.of(i).end());
      double sum = 0;
      for (const std::uint32_t m : ids) {
        ASSERT_LT(m, n);
        ASSERT_NE(m, i);
        here.push_back(sq_distance(i, m));
        sum += std::sqrt(here.back());
      }
      std::sort(here.begin(), here.end());
      std::sort(ids.begin(), ids.end());
      ASSERT_EQ(std::adjacent_find(ids.begin(), ids.end()), ids.end()) << "twice the same";
      for (std::uint32_t j = 0; j < found; ++j) ASSERT_EQ(here[j], truth[j]) << i << ", " << j;
      if (found > 0) {
        ASSERT_NEAR(search_.mean_distance()[i], sum / found, 1e-5 * sum);
      }
    }
  }

  float sq_distance(std::uint32_t i, std::uint32_t m) const {
    const float dx = search_.x()[m] - search_.x()[i], dy = search_.y()[m] - search_.y()[i],
                dz = search_.z()[m] - search_.z()[i];
    return dx * dx + dy * dy + dz * dz;
  }

  std::vector<float> distances_from(std::uint32_t i) const {
    std::vector<float> all;
    for (std::uint32_t m = 0; m < search_.size(); ++m) {
      if (m != i) all.push_back(sq_distance(i, m));
    }
    return all;
  }

  Arena arena_;
  PointNeighbours search_;
};

std::vector<Point3f> even_points(std::size_t count, std::uint64_t seed) {
  Pcg32 random(seed);
  std::vector<Point3f> points(count);
  for (Point3f& p : points) {
    p = {static_cast<float>(random.uniform()), static_cast<float>(random.uniform()),
         static_cast<float>(random.uniform())};
  }
  return points;
}

/// As a spinning sensor sees a floor and a wall: spacing from millimetres to metres, and strays.
std::vector<Point3f> uneven_points(std::size_t count, std::uint64_t seed) {
  Pcg32 random(seed);
  std::vector<Point3f> points(count);
  for (Point3f& p : points) {
    const double r = 0.3 * std::pow(100.0, random.uniform()), a = 6.2832 * random.uniform();
    p = {static_cast<float>(r * std::cos(a)), static_cast<float>(r * std::sin(a)),
         static_cast<float>(random.below(50) == 0 ? 20 * random.uniform() : 0.01 * r)};
  }
  return points;
}

TEST_F(PointNeighboursTest, FindsWhatBruteForceFinds) {
  for (const std::uint32_t k : {1U, 5U, 30U}) {
    const std::size_t points = test::kSanitized ? 300 : 1500;  // their square is what it takes
    expect_as_brute_force(even_points(points, k), k);
    expect_as_brute_force(uneven_points(points, k), k);
  }
}

TEST_F(PointNeighboursTest, FindsWhatBruteForceFindsAtEverySmallSize) {
  for (std::size_t n = 0; n < 70; ++n) expect_as_brute_force(even_points(n, n), 30);
}

TEST_F(PointNeighboursTest, FindsWhatNanoflannFinds) {
  const std::vector<Point3f> points = uneven_points(20000, 7);
  ASSERT_EQ(search_.search(points, 30, 1e9F), Status::kOk);
  const KdTreeSearch tree(points);
  std::vector<Neighbour> truth(31);
  for (std::uint32_t i = 0; i < search_.size(); i += 7) {
    ASSERT_EQ(tree.knn(points[search_.source()[i]], truth), 31U);
    double farthest = 0;
    for (const std::uint32_t m : search_.of(i))
      farthest = std::max<double>(farthest, sq_distance(i, m));
    ASSERT_NEAR(farthest, truth.back().sq_dist, 1e-5 * truth.back().sq_dist);
  }
}

TEST_F(PointNeighboursTest, CopesWithPilesLinesAndGrids) {
  std::vector<Point3f> pile(500, Point3f{1, 2, 3});
  expect_as_brute_force(pile, 30);
  const std::vector<Point3f> others = even_points(300, 3);
  pile.insert(pile.end(), others.begin(), others.end());
  expect_as_brute_force(pile, 30);
  std::vector<Point3f> line, grid;
  for (int i = 0; i < 400; ++i) {
    line.push_back({static_cast<float>(i), 0, 0});
    grid.push_back({static_cast<float>(i % 20), static_cast<float>(i / 20), 5});
  }
  expect_as_brute_force(line, 12);
  expect_as_brute_force(grid, 12);
}

TEST_F(PointNeighboursTest, ALargePileCostsNoSquareOfItsSize) {
  std::vector<Point3f> points(kMostPoints, Point3f{0, 0, 0});  // 3.6e9 distances by definition
  for (std::size_t i = 0; i < 100; ++i) points[i * 7].x = static_cast<float>(i);
  ASSERT_EQ(search_.search(points, 30, 1e9F), Status::kOk);
  for (std::uint32_t i = 0; i < search_.size(); i += 997) {
    if (search_.x()[i] != 0) continue;
    for (const std::uint32_t m : search_.of(i)) ASSERT_EQ(sq_distance(i, m), 0.0F);
  }
}

TEST_F(PointNeighboursTest, FindsWhatBruteForceFindsFarFromTheOrigin) {
  std::vector<Point3f> points = even_points(800, 11);
  for (Point3f& p : points) {
    p.x = p.x * 100 + 512000;
    p.y = p.y * 100 + 5403000;
  }
  expect_as_brute_force(points, 20);
}

TEST_F(PointNeighboursTest, LeavesOutWhatIsNotFiniteOrTooFarAndLeadsBack) {
  std::vector<Point3f> points = even_points(500, 13);
  points[3].y = std::numeric_limits<float>::quiet_NaN();
  points[5].x = std::numeric_limits<float>::infinity();
  points[9].z = 1e30F;
  ASSERT_EQ(search_.search(points, 8, 1e9F), Status::kOk);
  ASSERT_EQ(search_.size(), 497U);
  std::vector<std::uint32_t> sources(search_.source().begin(), search_.source().end());
  for (std::uint32_t i = 0; i < search_.size(); ++i) {
    ASSERT_EQ(search_.x()[i], points[sources[i]].x);
    ASSERT_EQ(search_.z()[i], points[sources[i]].z);
  }
  std::sort(sources.begin(), sources.end());
  EXPECT_EQ(std::adjacent_find(sources.begin(), sources.end()), sources.end());
  expect_as_brute_force(points, 8);
}

TEST_F(PointNeighboursTest, TinyDistancesWhoseSquaresVanishStillGiveNeighbours) {
  std::vector<Point3f> points;
  for (int i = 0; i < 100; ++i) points.push_back({static_cast<float>(i) * 1e-30F, 0, 0});
  expect_as_brute_force(points, 10);
}

TEST_F(PointNeighboursTest, RefusesWhatItHasNoMemoryFor) {
  EXPECT_EQ(search_.search(std::vector<Point3f>(kMostPoints + 1), 5, 1e9F), Status::kFrameTooLarge);
  EXPECT_EQ(search_.search(std::vector<Point3f>(10), kMostNeighbours + 1, 1e9F),
            Status::kBadConfig);
  EXPECT_EQ(search_.search(std::vector<Point3f>(10), 0, 1e9F), Status::kBadConfig);
  EXPECT_EQ(search_.search(std::vector<Point3f>(10), 5, 1e30F), Status::kBadConfig);
}

}  // namespace
}  // namespace planecast
