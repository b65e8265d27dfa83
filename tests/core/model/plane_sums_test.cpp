// Plane sums against a direct least-squares solution.
#include "core/model/plane_sums.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "core/base/random.hpp"

namespace planecast {
namespace {

struct Reading {
  double x, y, w;
};

std::vector<Reading> noisy_plane(Pcg32& random, const FloatSurface& plane, int count,
                                 double noise) {
  std::vector<Reading> out;
  for (int i = 0; i < count; ++i) {
    const double x = random.uniform() - 0.5, y = random.uniform() - 0.5;
    out.push_back({x, y, plane.at(x, y) + noise * (random.uniform() - 0.5)});
  }
  return out;
}

PlaneSums sums_of(const std::vector<Reading>& readings) {
  PlaneSums s;
  for (const auto& [x, y, w] : readings)
    s.add({1, x, y, x * x, x * y, y * y, w, x * w, y * w, w * w});
  return s;
}

TEST(PlaneSums, SolveGivesBackThePlaneOfExactReadings) {
  Pcg32 random(6);
  const FloatSurface truth{1.25e5, -3e4, 7e5};
  FloatSurface found;
  ASSERT_TRUE(sums_of(noisy_plane(random, truth, 64, 0)).solve(found));
  EXPECT_NEAR(found.a, truth.a, 1e-4);
  EXPECT_NEAR(found.b, truth.b, 1e-4);
  EXPECT_NEAR(found.c, truth.c, 1e-4);
}

TEST(PlaneSums, NoOtherPlaneIsNearerToNoisyReadings) {
  Pcg32 random(7);
  const auto readings = noisy_plane(random, {1e5, 2e5, 9e5}, 100, 5e3);
  const PlaneSums sums = sums_of(readings);
  FloatSurface best;
  ASSERT_TRUE(sums.solve(best));
  const auto direct = [&](const FloatSurface& p) {
    double sum = 0;
    for (const Reading& r : readings) sum += (r.w - p.at(r.x, r.y)) * (r.w - p.at(r.x, r.y));
    return sum / static_cast<double>(readings.size());
  };
  EXPECT_NEAR(sums.mean_square(best), direct(best), 1e-6 * direct(best));
  for (int i = 0; i < 50; ++i) {
    FloatSurface other = best;
    other.a += 100 * (random.uniform() - 0.5);
    other.b += 100 * (random.uniform() - 0.5);
    other.c += 100 * (random.uniform() - 0.5);
    EXPECT_LE(direct(best), direct(other) * (1 + 1e-12));
  }
}

TEST(PlaneSums, MovingTheOriginMovesThePlaneWithIt) {
  Pcg32 random(8);
  const FloatSurface truth{3e4, -2e4, 5e5};
  FloatSurface found;
  ASSERT_TRUE(sums_of(noisy_plane(random, truth, 80, 0)).moved(0.3, -0.2, 1e5).solve(found));
  EXPECT_NEAR(found.at(0.3, -0.2), truth.at(0, 0) + 1e5, 1e-3);
  EXPECT_NEAR(found.a, truth.a, 1e-3);
}

TEST(PlaneSums, ReadingsOnOneLineHaveNoPlane) {
  PlaneSums line;
  for (int i = 0; i < 10; ++i) {
    const double x = 0.1 * i;
    line.add({1, x, 0, x * x, 0, 0, x, x * x, 0, x * x});
  }
  FloatSurface plane;
  EXPECT_FALSE(line.solve(plane));
  EXPECT_FALSE(PlaneSums{}.solve(plane));
  EXPECT_EQ(PlaneSums{}.mean_square(plane), 0);
}

}  // namespace
}  // namespace planecast
