// The score of found surfaces, on images small enough to count by hand.
#include "core/sim/surface_score.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace planecast {
namespace {

constexpr std::uint16_t kSide = 40;

struct Scene {
  std::vector<std::int32_t> x, y;
  RayTable rays;
  std::vector<std::uint16_t> ids = std::vector<std::uint16_t>(kSide * kSide, 1);
  std::vector<std::uint8_t> labels = std::vector<std::uint8_t>(kSide * kSide, 1);
  std::vector<TruthSurface> truth;
  std::vector<FoundSurface> found;

  Scene() {
    for (int i = 0; i < kSide; ++i) x.push_back((i - 20) << 20);
    for (int i = 0; i < kSide; ++i) y.push_back((i - 20) << 20);
    rays = {kSide, kSide, true, x, y};
    TruthSurface wall;
    wall.normal = {0, 0, 1};
    wall.distance = 2;
    TruthSurface slope;
    slope.normal = {0.6, 0, 0.8};
    slope.distance = 1.6;
    truth = {wall, slope};
    found = {{0, 0, 0.5}, {0.375, 0, 0.5}};
    for (std::size_t i = 0; i < ids.size(); ++i) {
      if (i % kSide < 20) ids[i] = labels[i] = 2;
    }
  }
  SurfaceScore score(const ScoreOptions& options = {}) const {
    return score_surfaces(rays, ids, truth, labels, found, options);
  }
};

TEST(SurfaceScore, CountsBothSurfacesWhereBothAreRight) {
  const SurfaceScore score = Scene().score();
  EXPECT_EQ(score.truth, 2U);
  EXPECT_EQ(score.found, 2U);
  EXPECT_EQ(score.matched, 2U);
  EXPECT_EQ(score.truth_of, (std::vector<std::uint16_t>{1, 2}));
}

TEST(SurfaceScore, MissesASurfaceThatPointsElsewhere) {
  Scene scene;
  scene.found[1].a = 0.43;  // over two degrees off
  EXPECT_EQ(scene.score().matched, 1U);
}

TEST(SurfaceScore, MissesSurfacesThatOverlapTooLittleEitherWay) {
  Scene scene;
  for (std::size_t i = 0; i < scene.labels.size(); ++i) {
    if (i % kSide < 25) scene.labels[i] = 2;  // a quarter too much: 0.8 of it is right, 0.75 of 1
  }
  EXPECT_EQ(scene.score().matched, 1U);
  for (std::uint8_t& label : scene.labels) label = 2;
  EXPECT_EQ(scene.score().matched, 0U);
  EXPECT_EQ(scene.score().found, 1U);
}

TEST(SurfaceScore, LeavesOutWhatIsSmallNarrowOrRound) {
  Scene scene;
  ScoreOptions options;
  options.min_pixels = 801;
  EXPECT_EQ(scene.score(options).truth, 0U);
  options = {};
  options.min_width = 21;
  EXPECT_EQ(scene.score(options).truth, 0U);
  EXPECT_EQ(scene.score(options).found, 0U);
  scene.truth[1].kind = TruthSurface::Kind::kSphere;
  EXPECT_EQ(scene.score().truth, 1U);
  EXPECT_EQ(scene.score().found, 1U);
}

TEST(SurfaceScore, TakesFacesInOnePlaneForOne) {
  Scene scene;
  scene.truth[1] = scene.truth[0];
  for (std::uint8_t& label : scene.labels) label = 1;
  const SurfaceScore score = scene.score();
  EXPECT_EQ(score.truth, 1U);
  EXPECT_EQ(score.matched, 1U);
}

TEST(SurfaceScore, NormalsOfFoundSurfacesFollowTheirPolynomial) {
  const Vec3 flat = found_normal({0, 0, 0.5}, 0.3, -0.2);
  EXPECT_NEAR(flat.z, 1, 1e-12);
  // 1 / z = c + d x^2 at x = 0 is flat, and leans beside.
  EXPECT_NEAR(found_normal({0, 0, 0.5, 1, 0, 0}, 0, 0).z, 1, 1e-12);
  EXPECT_GT(found_normal({0, 0, 0.5, 1, 0, 0}, 0.2, 0).x, 0.5);
}

}  // namespace
}  // namespace planecast
