#include "core/metrics/distance.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/base/random.hpp"

namespace planecast {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

using Points = std::vector<Point3f>;

Points random_points(std::size_t count, std::uint64_t seed) {
  Pcg32 random(seed);
  Points points(count);
  for (Point3f& p : points) {
    p = {static_cast<float>(random.uniform()), static_cast<float>(random.uniform()),
         static_cast<float>(random.uniform())};
  }
  return points;
}

/// Points every 10 cm on the plane z = 1 + slope x.
Points tilted_plane(int side, double slope) {
  Points points;
  for (int i = 0; i < side; ++i) {
    for (int j = 0; j < side; ++j) {
      const double x = 0.1 * i;
      points.push_back({static_cast<float>(x), static_cast<float>(0.1 * j),
                        static_cast<float>(1.0 + slope * x)});
    }
  }
  return points;
}

double distance(const Point3f& p, const Point3f& q) {
  return std::hypot(double{p.x} - q.x, double{p.y} - q.y, double{p.z} - q.z);
}

struct OneWay {
  double rmse = 0;
  double max = 0;
};

/// Nearest-point figures by definition, every point against every other.
OneWay one_way(const Points& from, const Points& to) {
  OneWay result;
  for (const Point3f& p : from) {
    double nearest = kInfinity;
    for (const Point3f& q : to) nearest = std::min(nearest, distance(p, q));
    result.rmse += nearest * nearest;
    result.max = std::max(result.max, nearest);
  }
  result.rmse = std::sqrt(result.rmse / static_cast<double>(from.size()));
  return result;
}

TEST(CloudDistance, AgreesWithBruteForceInBothDirections) {
  const Points a = random_points(700, 1);
  const Points b = random_points(400, 2);
  const OneWay ab = one_way(a, b);
  const OneWay ba = one_way(b, a);
  const CloudDistance d = cloud_distance(a, b);
  EXPECT_NEAR(d.d1_ab, ab.rmse, 1e-12);
  EXPECT_NEAR(d.d1_ba, ba.rmse, 1e-12);
  EXPECT_NEAR(d.d1, 0.5 * (ab.rmse + ba.rmse), 1e-12);
  EXPECT_NEAR(d.hausdorff_ab, ab.max, 1e-12);
  EXPECT_NEAR(d.hausdorff_ba, ba.max, 1e-12);
  EXPECT_NEAR(d.hausdorff, std::max(ab.max, ba.max), 1e-12);
  EXPECT_EQ(d.points_a, 700U);
  EXPECT_EQ(d.points_b, 400U);
}

TEST(CloudDistance, LostPointsShowFromTheOriginalOnly) {
  const Points a = {{0, 0, 0}, {1, 0, 0}};
  const Points b = {{0, 0, 0}};
  const CloudDistance d = cloud_distance(a, b);
  EXPECT_DOUBLE_EQ(d.d1_ab, std::sqrt(0.5));
  EXPECT_DOUBLE_EQ(d.d1_ba, 0.0);
  EXPECT_DOUBLE_EQ(d.d1, 0.5 * std::sqrt(0.5));
  EXPECT_DOUBLE_EQ(d.hausdorff_ab, 1.0);
  EXPECT_DOUBLE_EQ(d.hausdorff_ba, 0.0);
}

TEST(CloudDistance, AShiftWithinThePlaneIsFreePointToPlane) {
  const Points a = tilted_plane(20, 0.5);
  Points b = a;
  for (Point3f& p : b) p.y += 0.03F;
  const CloudDistance d = cloud_distance(a, b);
  EXPECT_NEAR(d.d1_ab, 0.03, 1e-6);
  EXPECT_LT(d.d2_ab, 1e-5);
  EXPECT_LT(d.d2_ba, 1e-5);
}

TEST(CloudDistance, AShiftAlongTheNormalCountsInFullPointToPlane) {
  const double slope = 0.5;
  const Points a = tilted_plane(20, slope);
  Points b = a;
  const double norm = std::sqrt(1.0 + slope * slope);
  for (Point3f& p : b) {
    p.x += static_cast<float>(-slope / norm * 0.02);
    p.z += static_cast<float>(1.0 / norm * 0.02);
  }
  const CloudDistance d = cloud_distance(a, b);
  EXPECT_NEAR(d.d1, 0.02, 1e-6);
  EXPECT_NEAR(d.d2_ab, 0.02, 1e-5);
  EXPECT_NEAR(d.d2_ba, 0.02, 1e-5);
  EXPECT_NEAR(d.d2, 0.02, 1e-5);
}

TEST(CloudDistance, NormalsStayRightFarFromTheOrigin) {
  Points a = tilted_plane(20, 0.0);
  for (Point3f& p : a) p.x += 3000.0F;
  Points b = a;
  for (Point3f& p : b) p.z += 0.02F;
  EXPECT_NEAR(cloud_distance(a, b).d2, 0.02, 1e-5);
}

TEST(CloudDistance, WithoutAPlaneTheWholeDistanceCounts) {
  const Points pair = {{0, 0, 0}, {1, 0, 0}};
  Points line;
  for (int i = 0; i < 50; ++i) line.push_back({static_cast<float>(i), 0, 0});
  const Points same(30, Point3f{1, 2, 3});
  for (const Points& a : {pair, line, same}) {
    Points b = a;
    for (Point3f& p : b) p.y += 0.25F;
    const CloudDistance d = cloud_distance(a, b);
    EXPECT_NEAR(d.d2_ab, 0.25, 1e-9);
    EXPECT_NEAR(d.d2_ba, 0.25, 1e-9);
  }
}

TEST(CloudDistance, PointToPlaneIsNeverMoreThanPointToPoint) {
  const CloudDistance d = cloud_distance(random_points(500, 3), random_points(500, 4));
  EXPECT_LE(d.d2_ab, d.d1_ab);
  EXPECT_LE(d.d2_ba, d.d1_ba);
  EXPECT_GT(d.d2_ab, 0.0);
}

TEST(CloudDistance, PointToPlaneIsLeftOutWhenNotAsked) {
  DistanceOptions options;
  options.point_to_plane = false;
  const CloudDistance d = cloud_distance(random_points(50, 3), random_points(50, 4), options);
  EXPECT_GT(d.d1, 0.0);
  EXPECT_EQ(d.d2, 0.0);
}

TEST(CloudDistance, SkipsPointsThatAreNotFinite) {
  Points a = random_points(300, 5);
  Points b = random_points(200, 6);
  const CloudDistance clean = cloud_distance(a, b);
  a.insert(a.begin(), Point3f{kNaN, 0, 0});
  b.insert(b.begin() + 100, Point3f{0, 0, std::numeric_limits<float>::infinity()});
  const CloudDistance d = cloud_distance(a, b);
  EXPECT_EQ(d.points_a, 300U);
  EXPECT_EQ(d.points_b, 200U);
  EXPECT_DOUBLE_EQ(d.d1, clean.d1);
  EXPECT_DOUBLE_EQ(d.d2, clean.d2);
}

TEST(CloudDistance, TwoEmptyCloudsAreEqualAndOneEmptyCloudIsInfinitelyFar) {
  const Points none;
  const Points holes(4, Point3f{kNaN, kNaN, kNaN});
  const Points some = random_points(5, 7);
  const CloudDistance both = cloud_distance(none, holes);
  EXPECT_EQ(both.d1, 0.0);
  EXPECT_EQ(both.hausdorff, 0.0);
  for (const auto& [a, b] : {std::pair{some, holes}, std::pair{none, some}}) {
    const CloudDistance d = cloud_distance(a, b);
    EXPECT_EQ(d.d1_ab, kInfinity);
    EXPECT_EQ(d.d1_ba, kInfinity);
    EXPECT_EQ(d.d2, kInfinity);
    EXPECT_EQ(d.hausdorff, kInfinity);
  }
}

TEST(MaxCorresponding, ComparesPointsOfTheSameIndexNotTheNearest) {
  // Swapping two points leaves every nearest-point figure 0.
  const Points a = {{0, 0, 0}, {1, 0, 0}, {5, 0, 0}};
  const Points b = {{1, 0, 0}, {0, 0, 0}, {5, 0, 0}};
  ASSERT_EQ(cloud_distance(a, b).hausdorff, 0.0);
  const auto result = max_corresponding(a, b);
  ASSERT_TRUE(result.ok());
  EXPECT_DOUBLE_EQ(result->max, 1.0);
  EXPECT_DOUBLE_EQ(result->rmse, std::sqrt(2.0 / 3.0));
  EXPECT_EQ(result->compared, 3U);
}

TEST(MaxCorresponding, NamesTheWorstPoint) {
  Points a = random_points(100, 8);
  Points b = a;
  b[71].z += 0.5F;
  b[20].z += 0.25F;
  const auto result = max_corresponding(a, b);
  ASSERT_TRUE(result.ok());
  EXPECT_EQ(result->worst_index, 71U);
  EXPECT_NEAR(result->max, 0.5, 1e-6);
}

TEST(MaxCorresponding, CountsPointsLostAndInvented) {
  Points a = random_points(10, 9);
  Points b = a;
  b[1].x = b[2].x = kNaN;
  a[7].y = kNaN;
  a[8].y = b[8].y = kNaN;
  const auto result = max_corresponding(a, b);
  ASSERT_TRUE(result.ok());
  EXPECT_EQ(result->only_original, 2U);
  EXPECT_EQ(result->only_decoded, 1U);
  EXPECT_EQ(result->compared, 6U);
  EXPECT_EQ(result->max, 0.0);
}

TEST(MaxCorresponding, RefusesCloudsOfDifferentSize) {
  const auto result = max_corresponding(random_points(3, 1), random_points(4, 1));
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.error().status, Status::kWrongSize);
  EXPECT_NE(result.error().message.find("3 and 4 points"), std::string::npos);
}

}  // namespace
}  // namespace planecast
