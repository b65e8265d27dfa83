// The point-cloud codecs of the benchmarks: as many points out as in, as near as each promises.
#include "bench/baselines/point_baselines.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "core/base/random.hpp"
#include "core/metrics/distance.hpp"

namespace planecast::baselines {
namespace {

// A floor and a wall with 1 mm of noise, clutter between them, and a point three times over.
PointList corner() {
  PointList points;
  Pcg32 random(3);
  const auto flat = [&random](double span) { return static_cast<float>(span * random.uniform()); };
  const auto noise = [&random] { return static_cast<float>(0.002 * (random.uniform() - 0.5)); };
  for (int i = 0; i < 6000; ++i) points.push_back({flat(2), flat(1.5), noise()});
  for (int i = 0; i < 4000; ++i) points.push_back({noise(), flat(1.5), 0.05f + flat(1)});
  for (int i = 0; i < 300; ++i) points.push_back({0.3f + flat(1), flat(1.5), 0.3f + flat(0.6)});
  for (int i = 0; i < 3; ++i) points.push_back({1.25f, 0.5f, 0.75f});
  return points;
}

PointList round_trip(const PointBaseline& codec, const PointList& points, std::size_t* bytes) {
  const Bytes coded = codec.encode(points);
  if (bytes != nullptr) *bytes = coded.size();
  return codec.decode(coded);
}

TEST(PointBaselines, AllReturnAsManyPointsInFewerBytes) {
  std::vector<std::string> skipped;
  for (const auto& codec : point_set(skipped)) {
    std::size_t bytes = 0;
    const std::size_t out = round_trip(*codec, corner(), &bytes).size();
    // Kammerl's leaves alone hold one point each.
    EXPECT_TRUE(codec->setting().ends_with("alone") ? out < corner().size()
                                                    : out == corner().size())
        << codec->name();
    EXPECT_LT(bytes, corner().size() * sizeof(Point3f)) << codec->name();
  }
  for (const std::string& peer : skipped) std::printf("skipped: %s\n", peer.c_str());
}

TEST(PointBaselines, AllReturnNothingForNothingAndOneForOne) {
  std::vector<std::string> skipped;
  for (const auto& codec : point_set(skipped)) {
    if (codec->name().starts_with("Draco")) continue;  // refuses an empty cloud
    EXPECT_TRUE(round_trip(*codec, {}, nullptr).empty()) << codec->name();
    const PointList one = round_trip(*codec, {{1, 2, 3}}, nullptr);
    ASSERT_EQ(one.size(), 1u) << codec->name();
    EXPECT_NEAR(one[0].y, 2, 0.01) << codec->name();
  }
}

TEST(PointBaselines, BurrowsWheelerIsLossless) {
  if (!available(ByteCoder::kBzip2)) GTEST_SKIP() << "bzip2: libbz2-dev is not installed";
  const PointList points = corner();
  const PointList back = round_trip(*byte_points(ByteCoder::kBzip2, 9), points, nullptr);
  ASSERT_EQ(back.size(), points.size());
  EXPECT_EQ(std::memcmp(back.data(), points.data(), points.size() * sizeof(Point3f)), 0);
}

TEST(PointBaselines, OctreesStayWithinTheirCells) {
  const PointList points = corner();
  const double half_diagonal = 0.01 * std::sqrt(3.0) / 2;
  const CloudDistance coarse =
      cloud_distance(points, round_trip(*octree2006(0.01), points, nullptr));
  EXPECT_LE(coarse.hausdorff, half_diagonal * 1.0001);
  EXPECT_GT(coarse.d1, 0.001);  // and it does round
  const CloudDistance fine = cloud_distance(points, round_trip(*octree2013(), points, nullptr));
  EXPECT_LE(fine.hausdorff, 2.0 / 65536 * std::sqrt(3.0));
}

TEST(PointBaselines, AnOctreeThatKnowsThePlaneNeedsFewerBitsThanItsPointsApart) {
  // The same number of points off any plane costs more: the prediction is what saves.
  PointList flat, scattered;
  Pcg32 random(5);
  for (int i = 0; i < 4000; ++i) {
    const auto x = static_cast<float>(random.uniform()), y = static_cast<float>(random.uniform());
    flat.push_back({x, y, 0.3f * x + 0.2f * y});
    scattered.push_back({x, y, static_cast<float>(random.uniform())});
  }
  std::size_t on_plane = 0, off_plane = 0;
  (void)round_trip(*octree2006(0.01), flat, &on_plane);
  (void)round_trip(*octree2006(0.01), scattered, &off_plane);
  EXPECT_LT(static_cast<double>(on_plane), 0.6 * static_cast<double>(off_plane));
}

TEST(PointBaselines, CodersOfPlanesPutPointsOnThemAndKeepTheRest) {
  const PointList points = corner();
  std::vector<std::unique_ptr<PointBaseline>> codecs;
  codecs.push_back(morell2014(1));
  codecs.push_back(morell2014(5));
  codecs.push_back(dt2016(0.1));
  codecs.push_back(gmm2018());
  for (const auto& codec : codecs) {
    const PointList back = round_trip(*codec, points, nullptr);
    const CloudDistance far = cloud_distance(points, back);
    EXPECT_LT(far.d1_ab, 0.03) << codec->name() << codec->setting();
    EXPECT_LT(far.d2, 0.01) << codec->name() << codec->setting();
    int kept = 0;
    for (const Point3f& p : back) kept += p.x == 1.25f && p.y == 0.5f && p.z == 0.75f;
    EXPECT_EQ(kept, 3) << codec->name();
  }
}

TEST(PointBaselines, FewerPointsATriangleCostMoreBytesAndLessError) {
  std::size_t fine = 0, coarse = 0;
  const PointList points = corner();
  const PointList a = round_trip(*morell2014(1), points, &fine);
  const PointList b = round_trip(*morell2014(5), points, &coarse);
  EXPECT_GT(fine, coarse);
  EXPECT_LT(cloud_distance(points, a).d1, cloud_distance(points, b).d1);
}

TEST(PointBaselines, Kammerl2012KeepsPointsInTheirLeaves) {
  if (!kammerl2012_available()) GTEST_SKIP() << "PCL: libpcl-dev is not installed";
  const PointList points = corner();
  const PointList back = round_trip(*kammerl2012(0.001, 0.01, false), points, nullptr);
  EXPECT_LE(cloud_distance(points, back).hausdorff, 0.001 * std::sqrt(3.0) * 1.01);
  // A leaf alone comes back as its corner (PCL 1.13), up to a diagonal away.
  const PointList leaves = round_trip(*kammerl2012(0.01, 0.01, true), points, nullptr);
  EXPECT_LE(cloud_distance(points, leaves).hausdorff, 0.01 * std::sqrt(3.0) * 1.01);
}

TEST(PointBaselines, DracoStaysWithinItsStep) {
  if (!draco_available()) GTEST_SKIP() << "Draco: libdraco-dev is not installed";
  const PointList points = corner();
  for (const bool kd : {true, false}) {
    const PointList back = round_trip(*draco_points(kd, 7, 10), points, nullptr);
    EXPECT_LE(cloud_distance(points, back).hausdorff, 2.0 / 1023 * std::sqrt(3.0) / 2 * 1.01);
  }
}

}  // namespace
}  // namespace planecast::baselines
