// Normals and regions of unorganised points against definitions worked out one by one, with Eigen.
#include "core/segment/point_region_growing.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <deque>
#include <numbers>
#include <vector>

#include "core/base/random.hpp"
#include "core/model/least_eigen.hpp"
#include "core/segment/voxel_regions.hpp"

namespace planecast {
namespace {

constexpr std::uint32_t kMost = 4000;

/// Two walls and a floor with noise, and strays between them.
std::vector<Point3f> corner(std::size_t count, double noise, std::uint64_t seed) {
  Pcg32 random(seed);
  std::vector<Point3f> points;
  while (points.size() < count) {
    double p[3] = {random.uniform(), random.uniform(), random.uniform()};
    if (random.below(40) != 0) p[random.below(3)] = noise * (random.uniform() - 0.5);
    points.push_back(
        {static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])});
  }
  return points;
}

class PointRegionTest : public ::testing::Test {
 protected:
  PointRegionTest() : arena_(std::move(Arena::map(std::size_t{1} << 23U).value())) {
    cloud_.layout(arena_, kMost, 30);
    growing_.layout(arena_, kMost);
    voxels_.layout(arena_, kMost);
  }

  void measure(const std::vector<Point3f>& points, std::uint32_t k) {
    ASSERT_EQ(cloud_.search(points, k, 1e6F), Status::kOk);
    const std::size_t n = cloud_.size();
    x_.assign(n, 9);
    y_ = z_ = curvature_ = x_;
    removed_.assign(n, 0);
  }
  PointNormals normals() { return {x_, y_, z_, curvature_}; }

  Arena arena_;
  PointNeighbours cloud_;
  PointRegionGrowing growing_;
  VoxelRegions voxels_;
  std::vector<float> x_, y_, z_, curvature_;
  std::vector<std::uint8_t> removed_;
};

TEST_F(PointRegionTest, NormalsAndCurvaturesAreThoseOfTheCovariance) {
  measure(corner(1500, 0.02, 1), 20);
  for (std::uint32_t i = 0; i < cloud_.size(); i += 9) removed_[i] = 1;
  ASSERT_EQ(estimate_normals(cloud_, removed_, normals()), Status::kOk);
  for (std::uint32_t i = 0; i < cloud_.size(); ++i) {
    if (removed_[i] != 0) {
      ASSERT_EQ(curvature_[i], kNoCurvature);
      continue;
    }
    std::vector<Eigen::Vector3d> near = {{cloud_.x()[i], cloud_.y()[i], cloud_.z()[i]}};
    for (const std::uint32_t m : cloud_.of(i)) {
      if (removed_[m] == 0) near.push_back({cloud_.x()[m], cloud_.y()[m], cloud_.z()[m]});
    }
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const auto& p : near) mean += p / static_cast<double>(near.size());
    Eigen::Matrix3d c = Eigen::Matrix3d::Zero();
    for (const auto& p : near) c += (p - mean) * (p - mean).transpose();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(c);
    const Eigen::Vector3d values = solver.eigenvalues();
    ASSERT_NEAR(curvature_[i], values[0] / values.sum(), 2e-5);
    if (values[1] > 1.2 * values[0]) {
      const Eigen::Vector3d v(x_[i], y_[i], z_[i]);
      ASSERT_GT(std::abs(v.dot(solver.eigenvectors().col(0))), 0.9999);
    }
  }
}

TEST(LeastEigen, AgreesWithEigenOnLinesPlanesAndBalls) {
  Pcg32 random(5);
  for (int round = 0; round < 3000; ++round) {
    const Eigen::Vector3d scale(std::pow(10, -6 * random.uniform()),
                                std::pow(10, -6 * random.uniform()), 1);
    Eigen::Matrix3d a;
    for (int i = 0; i < 9; ++i) a(i / 3, i % 3) = random.uniform() - 0.5;
    const Eigen::Matrix3d q = Eigen::HouseholderQR<Eigen::Matrix3d>(a).householderQ();
    const Eigen::Matrix3d m = q * scale.asDiagonal() * q.transpose();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(m);
    LeastEigen least;
    ASSERT_TRUE(least_eigen({m(0, 0), m(0, 1), m(0, 2), m(1, 1), m(1, 2), m(2, 2)}, least));
    ASSERT_NEAR(least.share, solver.eigenvalues()[0] / m.trace(), 1e-9);
    const Eigen::Vector3d v(least.x, least.y, least.z);
    ASSERT_NEAR(v.norm(), 1, 1e-9);
    ASSERT_LT((m * v).norm(), solver.eigenvalues()[0] + 1e-4) << round;
  }
  LeastEigen least;
  EXPECT_FALSE(least_eigen({}, least));
}

/// Region growing as the paper tells it, with a queue and a set, on the same neighbours.
std::vector<std::uint32_t> by_definition(const PointNeighbours& cloud, const PointNormals& n,
                                         const PointRegionOptions& o) {
  const std::uint32_t count = cloud.size();
  std::vector<std::uint32_t> order(count), region(count, kNoRegion);
  for (std::uint32_t i = 0; i < count; ++i) order[i] = i;
  const auto key = [&](std::uint32_t i) {
    return std::min(65535U, static_cast<std::uint32_t>(n.curvature[i] * 65536.0F * 3.0F));
  };
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return key(a) < key(b); });
  const double least = std::cos(o.smoothness_deg * std::numbers::pi / 180);
  std::vector<bool> done(count, false);
  std::uint32_t next = 0;
  for (const std::uint32_t start : order) {
    if (done[start] || n.curvature[start] >= kNoCurvature) continue;
    std::vector<std::uint32_t> members = {start};
    std::deque<std::uint32_t> seeds = {start};
    done[start] = true;
    while (!seeds.empty()) {
      const std::uint32_t s = seeds.front();
      seeds.pop_front();
      for (const std::uint32_t m : cloud.of(s)) {
        if (done[m] || n.curvature[m] >= kNoCurvature) continue;
        const float dot = n.x[s] * n.x[m] + n.y[s] * n.y[m] + n.z[s] * n.z[m];
        if (std::abs(dot) < static_cast<float>(least)) continue;
        done[m] = true;
        members.push_back(m);
        const float test = o.test == CurvatureTest::kDifference
                               ? std::abs(n.curvature[m] - n.curvature[s])
                               : n.curvature[m];
        if (test <= static_cast<float>(o.curvature_limit)) seeds.push_back(m);
      }
    }
    if (members.size() < o.min_points) continue;
    for (const std::uint32_t m : members) region[m] = next;
    ++next;
  }
  return region;
}

TEST_F(PointRegionTest, GrowsTheRegionsOfTheDefinition) {
  measure(corner(2500, 0.01, 3), 15);
  ASSERT_EQ(estimate_normals(cloud_, removed_, normals()), Status::kOk);
  for (const double angle : {1.0, 3.0, 10.0, 30.0}) {
    for (const CurvatureTest test : {CurvatureTest::kDifference, CurvatureTest::kAbsolute}) {
      const PointRegionOptions options{angle, test, 0.01, 20};
      std::vector<std::uint32_t> regions(cloud_.size());
      PointRegionReport report;
      ASSERT_EQ(growing_.grow(cloud_, normals(), options, regions, report), Status::kOk);
      ASSERT_EQ(regions, by_definition(cloud_, normals(), options)) << angle;
      EXPECT_EQ(report.points, regions.size() - static_cast<std::size_t>(std::count(
                                                    regions.begin(), regions.end(), kNoRegion)));
    }
  }
}

TEST_F(PointRegionTest, ACornerIsThreeRegionsWithSmallDistancesInside) {
  measure(corner(4000, 0.002, 5), 20);
  ASSERT_EQ(estimate_normals(cloud_, removed_, normals()), Status::kOk);
  std::vector<std::uint32_t> regions(cloud_.size());
  PointRegionReport report;
  const PointRegionOptions options{6.0, CurvatureTest::kDifference, 0.02, 200};
  ASSERT_EQ(growing_.grow(cloud_, normals(), options, regions, report), Status::kOk);
  EXPECT_EQ(report.regions, 3U);
  EXPECT_GT(report.points, 3000U);
  EXPECT_GT(report.clusters, report.regions);
  EXPECT_GT(report.intra_distance, 0);
  EXPECT_LT(report.intra_distance, report.inter_distance);
}

TEST_F(PointRegionTest, VoxelsFindTheSameThreePlanes) {
  const std::vector<Point3f> points = corner(4000, 0.004, 7);
  PointRegionReport report;
  VoxelRegionOptions options;
  options.min_points = 200;
  ASSERT_EQ(voxels_.find(points, 1e6F, options, report), Status::kOk);
  EXPECT_EQ(report.regions, 3U);
  EXPECT_GT(report.points, 2600U);
  ASSERT_EQ(voxels_.size(), points.size());
  std::vector<bool> seen(points.size(), false);
  for (std::uint32_t i = 0; i < voxels_.size(); ++i) {
    const std::uint32_t source = voxels_.source()[i];
    ASSERT_FALSE(seen[source]);
    seen[source] = true;
    ASSERT_EQ(voxels_.x()[i], points[source].x);
    ASSERT_TRUE(voxels_.regions()[i] < 3 || voxels_.regions()[i] == kNoRegion);
  }
}

TEST_F(PointRegionTest, RefusesSizesAndOptions) {
  measure(corner(100, 0.01, 9), 10);
  std::vector<std::uint8_t> few(99);
  EXPECT_EQ(estimate_normals(cloud_, few, normals()), Status::kWrongSize);
  ASSERT_EQ(estimate_normals(cloud_, removed_, normals()), Status::kOk);
  std::vector<std::uint32_t> regions(99);
  PointRegionReport report;
  EXPECT_EQ(growing_.grow(cloud_, normals(), {}, regions, report), Status::kWrongSize);
  regions.resize(100);
  PointRegionOptions options;
  options.smoothness_deg = 91;
  EXPECT_EQ(growing_.grow(cloud_, normals(), options, regions, report), Status::kBadConfig);
  VoxelRegionOptions voxels;
  voxels.voxel_m = 0;
  EXPECT_EQ(voxels_.find(corner(10, 0, 1), 1e6F, voxels, report), Status::kBadConfig);
  EXPECT_EQ(voxels_.find(std::vector<Point3f>(kMost + 1), 1e6F, {}, report),
            Status::kFrameTooLarge);
}

}  // namespace
}  // namespace planecast
