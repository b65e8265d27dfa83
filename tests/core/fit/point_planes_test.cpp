// Planes by consensus: recovered under noise, several in a region, no point in two.
#include "core/fit/point_planes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

namespace planecast {
namespace {

constexpr std::uint32_t kMost = 20000;

struct Columns {
  std::vector<float> x, y, z;
  PointColumns view() const { return {x, y, z}; }
  void add(double a, double b, double c) {
    x.push_back(static_cast<float>(a));
    y.push_back(static_cast<float>(b));
    z.push_back(static_cast<float>(c));
  }
};

/// Near Gaussian, sigma 1.
double bell(Pcg32& random) {
  double sum = -6;
  for (int i = 0; i < 12; ++i) sum += random.uniform();
  return sum;
}

class PointPlanesTest : public ::testing::Test {
 protected:
  PointPlanesTest() : arena_(std::move(Arena::map(std::size_t{1} << 21U).value())) {
    fitter_.layout(arena_, kMost);
  }

  Status fit(const Columns& c, std::uint32_t regions, const PointPlaneOptions& options) {
    planes_.assign(c.x.size() / options.min_points + 1, {});
    members_.assign(c.x.size(), 0);
    return fitter_.fit(c.view(), region_, regions, options, planes_, planes_found_, members_,
                       members_found_);
  }

  Arena arena_;
  PointPlaneFitter fitter_;
  std::vector<std::uint32_t> region_;
  std::vector<PointPlane> planes_;
  std::vector<std::uint32_t> members_;
  std::uint32_t planes_found_ = 0, members_found_ = 0;
};

TEST_F(PointPlanesTest, RecoversTiltWithin0p2DegreeAnd1mmAt5mmNoise) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Pcg32 random(seed);
    Columns c;
    double n[3] = {random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5};
    const double length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    for (double& v : n) v /= length;
    const double far = 3;
    for (int i = 0; i < 3000; ++i) {
      const double p[3] = {random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5};
      const double h = p[0] * n[0] + p[1] * n[1] + p[2] * n[2];
      const double up = far + 0.005 * bell(random) - h;
      c.add(p[0] + up * n[0], p[1] + up * n[1], p[2] + up * n[2]);
    }
    region_.assign(3000, 0);
    PointPlaneOptions options;
    options.distance_m = 0.015;
    options.seed = seed;
    ASSERT_EQ(fit(c, 1, options), Status::kOk);
    ASSERT_GE(planes_found_, 1U);
    const PointPlane& p = planes_[0];
    const double cosine = std::abs(p.a * n[0] + p.b * n[1] + p.c * n[2]);
    EXPECT_LT(std::acos(std::min(1.0, cosine)) * 180 / std::numbers::pi, 0.2);
    EXPECT_NEAR(std::abs(p.d), far, 0.001);
    EXPECT_GT(p.count, 2900U);
    for (const std::uint32_t m : std::span(members_).subspan(p.first, p.count)) {
      ASSERT_LE(std::abs(p.a * c.x[m] + p.b * c.y[m] + p.c * c.z[m] + p.d), 0.01501);
    }
  }
}

TEST_F(PointPlanesTest, FindsSeveralPlanesInARegionAndNoPointTwice) {
  Pcg32 random(3);
  Columns c;
  for (int i = 0; i < 4000; ++i) {  // a step: two treads and a riser
    const double u = random.uniform(), v = random.uniform();
    if (i % 3 == 0) c.add(u, v * 0.5, 0);
    if (i % 3 == 1) c.add(u, 0.5, 0.3 * v);
    if (i % 3 == 2) c.add(u, 0.5 + v * 0.5, 0.3);
  }
  region_.assign(4000, 0);
  ASSERT_EQ(fit(c, 1, {}), Status::kOk);
  EXPECT_EQ(planes_found_, 3U);
  EXPECT_GT(members_found_, 3950U);
  std::vector<bool> taken(4000, false);
  for (const std::uint32_t m : std::span(members_).first(members_found_)) {
    ASSERT_FALSE(taken[m]);
    taken[m] = true;
  }
}

TEST_F(PointPlanesTest, TheSameSeedGivesTheSamePlanes) {
  Pcg32 random(4);
  Columns c;
  for (int i = 0; i < 900; ++i) c.add(random.uniform(), random.uniform(), 0.05 * random.uniform());
  region_.assign(900, 0);
  PointPlaneOptions options;
  options.seed = 77;
  ASSERT_EQ(fit(c, 1, options), Status::kOk);
  const std::vector<std::uint32_t> first = members_;
  const PointPlane plane = planes_[0];
  ASSERT_EQ(fit(c, 1, options), Status::kOk);
  EXPECT_EQ(members_, first);
  EXPECT_EQ(planes_[0].d, plane.d);
}

TEST_F(PointPlanesTest, EqualAndCollinearPointsGiveNoPlaneOrOneThatHoldsThem) {
  for (const bool line : {false, true}) {
    Columns c;
    for (int i = 0; i < 200; ++i) c.add(line ? 0.01 * i : 1, 2, 3);
    region_.assign(200, 0);
    ASSERT_EQ(fit(c, 1, {}), Status::kOk);
    for (std::uint32_t p = 0; p < planes_found_; ++p) {
      EXPECT_TRUE(std::isfinite(planes_[p].d));
    }
  }
}

TEST_F(PointPlanesTest, PointsInNoRegionAreLeftAlone) {
  Columns c;
  for (int i = 0; i < 300; ++i) c.add(i % 20, i / 20, 0);
  region_.assign(300, 5);
  ASSERT_EQ(fit(c, 2, {}), Status::kOk);
  EXPECT_EQ(planes_found_, 0U);
  EXPECT_EQ(members_found_, 0U);
}

TEST_F(PointPlanesTest, RefusesSizesOptionsAndTooFewPlaces) {
  Columns c;
  for (int i = 0; i < 300; ++i) c.add(i % 20, i / 20, 0);
  region_.assign(299, 0);
  EXPECT_EQ(fit(c, 1, {}), Status::kWrongSize);
  region_.assign(300, 0);
  PointPlaneOptions options;
  options.distance_m = 0;
  EXPECT_EQ(fit(c, 1, options), Status::kBadConfig);
  std::vector<PointPlane> none;
  EXPECT_EQ(fitter_.fit(c.view(), region_, 1, {}, none, planes_found_, members_, members_found_),
            Status::kTooLarge);
}

}  // namespace
}  // namespace planecast
