#include "apps/common/near_grid.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "core/base/random.hpp"

namespace planecast {
namespace {

constexpr double kReach_m = 0.1;

float coordinate(Pcg32& random, std::uint32_t steps) {
  return static_cast<float>(random.next() % steps) * 0.01F;
}

// Points on a coarse lattice: many equal ones, many distances that tie.
std::vector<Point3f> lattice_points(std::uint64_t seed, std::size_t n, std::uint32_t steps) {
  Pcg32 random(seed);
  std::vector<Point3f> points(n);
  for (Point3f& p : points)
    p = {coordinate(random, steps), coordinate(random, steps), coordinate(random, steps)};
  return points;
}

double brute_force_m(const std::vector<Point3f>& from, const std::vector<Point3f>& to) {
  double worst = 0;
  for (const Point3f& p : from) {
    double best = std::numeric_limits<double>::infinity();
    for (const Point3f& q : to)
      best = std::min(best, std::hypot(double{p.x} - q.x, double{p.y} - q.y, double{p.z} - q.z));
    worst = std::max(worst, best);
  }
  return worst <= kReach_m ? worst : std::numeric_limits<double>::infinity();
}

double farthest_m(const std::vector<Point3f>& from, const std::vector<Point3f>& to) {
  NearGrid a, b;
  a.reserve(from.size());
  b.reserve(to.size());
  EXPECT_TRUE(a.fill(from, kReach_m) && b.fill(to, kReach_m));
  return a.farthest_m(b);
}

TEST(NearGrid, FarthestPointIsThatOfBruteForce) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const auto from = lattice_points(seed, 300, 25), to = lattice_points(seed + 100, 2000, 25);
    ASSERT_TRUE(std::isfinite(brute_force_m(from, to))) << seed;
    EXPECT_DOUBLE_EQ(farthest_m(from, to), brute_force_m(from, to)) << seed;
    EXPECT_DOUBLE_EQ(farthest_m(to, from), brute_force_m(to, from)) << seed;
  }
}

TEST(NearGrid, APointWithNoneWithinTheDistanceIsInfinitelyFar) {
  auto from = lattice_points(1, 100, 25);
  const auto to = lattice_points(2, 2000, 25);
  from.push_back({5, 0, 0});
  EXPECT_TRUE(std::isinf(farthest_m(from, to)));
}

TEST(NearGrid, RefusesMorePointsThanItHasRoomFor) {
  NearGrid grid;
  grid.reserve(2);
  EXPECT_FALSE(grid.fill(lattice_points(1, 3, 5), kReach_m));
}

}  // namespace
}  // namespace planecast
