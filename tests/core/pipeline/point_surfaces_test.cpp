// Both chains from points to patches and back: every point counted once, what comes back lies near
// what went in, and degenerate clouds end in a result.
#include "core/pipeline/point_surfaces.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/base/random.hpp"
#include "core/regen/patch_fill.hpp"
#include "core/wire/patch_pack.hpp"
#include "core/wire/patch_unpack.hpp"
#include "tests/support/heap_guard.hpp"

namespace planecast {
namespace {

constexpr std::uint32_t kMost = 12000;
constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

class PointSurfacesTest : public ::testing::TestWithParam<PointMethod> {
 protected:
  PointSurfacesTest() : options_(point_surface_defaults(GetParam(), 0.02)) {
    Arena measure = Arena::measuring();
    surfaces_.layout(measure, kMost, options_);
    arena_ = std::move(Arena::map(measure.bytes_needed() + (std::size_t{1} << 22U)).value());
    surfaces_.layout(arena_, kMost, options_);
    packer_.layout(arena_);
    unpacker_.layout(arena_);
    filler_.layout(arena_);
    stream_.patch_unit_nm = options_.patch_unit_nm;
    EXPECT_FALSE(arena_.failed());
  }

  Status run(const std::vector<Point3f>& points) {
    Status status = surfaces_.filter(points, options_);
    if (status == Status::kOk) status = surfaces_.segment(points, options_);
    if (status == Status::kOk) status = surfaces_.fit(points, options_);
    return status;
  }

  std::size_t count(PointRole role) const {
    return static_cast<std::size_t>(
        std::count(surfaces_.roles().begin(), surfaces_.roles().end(), role));
  }

  /// Packs what was found and hands over each patch as it is decoded.
  template <class F>
  void each_patch(F&& take) {
    std::vector<std::uint8_t> bytes(std::size_t{1} << 18U);
    std::vector<SlicePlace> places(500);
    FrameReport report;
    ASSERT_EQ(packer_.pack(surfaces_.drafts(), surfaces_.cells(), {}, 1200, bytes, places, report),
              Status::kOk);
    for (const SlicePlace& p : std::span(places).first(report.slices)) {
      ASSERT_EQ(unpacker_.begin(std::span(bytes).subspan(p.offset + kPacketHeaderBytes,
                                                         p.bytes - kPacketHeaderBytes)),
                Status::kOk);
      while (unpacker_.left() > 0) {
        Patch patch;
        std::span<const std::uint8_t> cells;
        ASSERT_EQ(unpacker_.next(patch, cells), Status::kOk);
        take(patch, cells);
      }
    }
  }

  /// Packs what was found in slices of 1200 B and regenerates it from them.
  std::vector<Point3f> through_the_wire() {
    std::vector<std::uint8_t> bytes(std::size_t{1} << 18U);
    std::vector<SlicePlace> places(500);
    FrameReport report;
    EXPECT_EQ(packer_.pack(surfaces_.drafts(), surfaces_.cells(), {}, 1200, bytes, places, report),
              Status::kOk);
    std::vector<Point3f> out(report.points);
    std::size_t next = 0;
    for (std::uint32_t s = 0; s < report.slices; ++s) {
      const SlicePlace p = places[s];
      EXPECT_EQ(unpacker_.begin(std::span(bytes).subspan(p.offset + kPacketHeaderBytes,
                                                         p.bytes - kPacketHeaderBytes)),
                Status::kOk);
      Pcg32 generator = patch_generator(stream_, 0, s);
      while (unpacker_.left() > 0) {
        Patch patch;
        std::span<const std::uint8_t> cells;
        if (unpacker_.next(patch, cells) != Status::kOk) return {};
        EXPECT_EQ(filler_.fill(patch, cells, stream_, generator,
                               std::span(out).subspan(next, patch.points)),
                  Status::kOk);
        next += patch.points;
      }
    }
    EXPECT_EQ(next, out.size());
    return out;
  }

  PointSurfaceOptions options_;
  Arena arena_;
  PointSurfaces surfaces_;
  PatchPacker packer_;
  PatchUnpacker unpacker_;
  PatchFiller filler_;
  PointStream stream_;
};

/// A floor and a wall of 2 m with a window, 4 mm of noise, and strays.
std::vector<Point3f> room(double off_x = 0, double off_y = 0) {
  Pcg32 random(1);
  std::vector<Point3f> points;
  while (points.size() < kMost) {
    const double u = 2 * random.uniform(), v = 2 * random.uniform();
    const double noise = 0.004 * (random.uniform() - 0.5);
    double p[3] = {u, v, noise};
    if (random.below(2) == 0) {
      if (u > 0.7 && u < 1.3 && v > 0.7 && v < 1.3) continue;
      p[1] = noise;
      p[2] = v;
    }
    if (random.below(100) == 0) p[2] += 0.3 + random.uniform();
    points.push_back({static_cast<float>(p[0] + off_x), static_cast<float>(p[1] + off_y),
                      static_cast<float>(p[2])});
  }
  return points;
}

TEST_P(PointSurfacesTest, ARoomComesBackOnItsTwoPlanesAndPointsAreCountedOnce) {
  const std::vector<Point3f> points = room();
  ASSERT_EQ(run(points), Status::kOk);
  EXPECT_GT(surfaces_.on_surface(), kMost * 75 / 100);
  EXPECT_EQ(count(PointRole::kOnSurface), surfaces_.on_surface());
  EXPECT_EQ(count(PointRole::kUnusable), 0U);
  for (const FillMode fill : {FillMode::kLattice, FillMode::kRandom}) {
    stream_.fill = fill;
    const std::vector<Point3f> out = through_the_wire();
    ASSERT_EQ(out.size(), surfaces_.on_surface());
    std::size_t in_window = 0;
    for (const Point3f& p : out) {
      ASSERT_LT(std::min(std::abs(p.y), std::abs(p.z)), 0.015F);
      in_window += p.z > 0.1F && std::max(std::abs(p.x - 1), std::abs(p.z - 1)) < 0.2F ? 1 : 0;
    }
    EXPECT_EQ(in_window, 0U) << "the hole of the wall stays open";
  }
}

// Every point on a surface against the patches as they are decoded: one has it in a cell, and
// within the plane's distance but for the rounding of its coefficients.
TEST_P(PointSurfacesTest, EveryPointOnASurfaceLiesInACellOfADecodedPatchAndOnItsPlane) {
  const std::vector<Point3f> points = room();
  ASSERT_EQ(run(points), Status::kOk);
  std::vector<bool> found(points.size(), false);
  double worst = 0;
  const double unit = patch_unit_m(stream_);
  each_patch([&](const Patch& patch, std::span<const std::uint8_t> cells) {
    const PatchSurface surface(patch);
    // By how much a step along the surface is longer than its shadow: distance from the height.
    const double ends[3] = {static_cast<double>(surface.height(0, 0)),
                            static_cast<double>(surface.height(1 << 16, 0)),
                            static_cast<double>(surface.height(0, 1 << 16))};
    const double lean = std::hypot(1, (ends[1] - ends[0]) / 65536, (ends[2] - ends[0]) / 65536);
    const double side = unit * (1U << patch.pitch_log2);
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (surfaces_.roles()[i] != PointRole::kOnSurface || found[i]) continue;
      const double p[3] = {points[i].x, points[i].y, points[i].z};
      const double u = p[patch.axis == 0 ? 1 : 0], v = p[patch.axis == 2 ? 1 : 2];
      const auto a = static_cast<std::int64_t>(std::floor(u / side)) - patch.cell_u;
      const auto b = static_cast<std::int64_t>(std::floor(v / side)) - patch.cell_v;
      if (a < 0 || b < 0 || a >= patch.wide || b >= patch.high) continue;
      if (cells[static_cast<std::size_t>(b * patch.wide + a)] == 0) continue;
      const double height = unit * static_cast<double>(surface.height(std::llround(u / unit),
                                                                      std::llround(v / unit)));
      const double off = std::abs(p[patch.axis] - height) / lean;
      if (off > 1.1 * options_.planes.distance_m) continue;
      found[i] = true;
      worst = std::max(worst, off);
    }
  });
  EXPECT_EQ(static_cast<std::size_t>(std::count(found.begin(), found.end(), true)),
            surfaces_.on_surface());
  EXPECT_GT(worst, 0.0005);  // noise is 2 mm either way
}

TEST_P(PointSurfacesTest, TheSameFrameTwiceGivesTheSamePatches) {
  const std::vector<Point3f> points = room();
  ASSERT_EQ(run(points), Status::kOk);
  const std::vector<Point3f> first = through_the_wire();
  ASSERT_EQ(run(std::vector<Point3f>(50, Point3f{1, 1, 1})), Status::kOk);
  ASSERT_EQ(run(points), Status::kOk);
  const std::vector<Point3f> second = through_the_wire();
  ASSERT_EQ(first.size(), second.size());
  for (std::size_t i = 0; i < first.size(); ++i) {
    ASSERT_EQ(first[i].x, second[i].x);
    ASSERT_EQ(first[i].z, second[i].z);
  }
}

TEST_P(PointSurfacesTest, DegenerateCloudsEndInAResultWithEveryPointCounted) {
  Pcg32 random(2);
  std::vector<std::vector<Point3f>> clouds;
  for (std::size_t n = 0; n < 4; ++n) clouds.emplace_back(n, Point3f{1, 2, 3});
  clouds.emplace_back(5000, Point3f{1, 2, 3});          // all equal
  clouds.emplace_back(100, Point3f{kNaN, 0, 0});        // none
  clouds.emplace_back(100, Point3f{1e30F, -1e30F, 0});  // none within reach
  clouds.emplace_back();                                // a line
  for (int i = 0; i < 3000; ++i) clouds.back().push_back({0.001F * static_cast<float>(i), 0, 0});
  clouds.emplace_back(room());  // a few bad ones among good ones
  clouds.back()[7].x = kNaN;
  clouds.back()[8].y = std::numeric_limits<float>::infinity();
  clouds.back()[9].z = 1e30F;
  clouds.emplace_back(room());  // all twice
  std::copy_n(clouds.back().begin(), kMost / 2, clouds.back().begin() + kMost / 2);
  for (const std::vector<Point3f>& cloud : clouds) {
    ASSERT_EQ(run(cloud), Status::kOk) << cloud.size();
    ASSERT_EQ(surfaces_.roles().size(), cloud.size());
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const Point3f& p = cloud[i];
      const float far = std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)});
      const bool usable = std::isfinite(p.x + p.y + p.z) && far < 1e9F;
      ASSERT_EQ(surfaces_.roles()[i] != PointRole::kUnusable, usable);
    }
    std::uint64_t points = 0;
    for (const PatchDraft& d : surfaces_.drafts()) points += d.points;
    ASSERT_EQ(points, count(PointRole::kOnSurface));
    for (const Point3f& p : through_the_wire()) ASSERT_TRUE(std::isfinite(p.x + p.y + p.z));
  }
}

TEST_P(PointSurfacesTest, OffsetsOfAMapGridStillGiveThePlanes) {
  // Floats have 3 cm steps in x and 0.5 m in y there: no quality is promised, but an end.
  ASSERT_EQ(run(room(30000, 20000)), Status::kOk);
  (void)through_the_wire();
  ASSERT_EQ(run(room(300, 200)), Status::kOk);
  EXPECT_GT(surfaces_.on_surface(), kMost / 2);
}

TEST_P(PointSurfacesTest, TakesNothingFromTheHeap) {
  using test::HeapGuard;
  if (!HeapGuard::available()) GTEST_SKIP() << "the heap guard is not in this build";
  const std::vector<Point3f> points = room();
  std::vector<std::uint8_t> bytes(std::size_t{1} << 18U);
  std::vector<SlicePlace> places(500);
  FrameReport report;
  HeapGuard::reset();
  HeapGuard::arm_this_thread("surfaces");
  const Status found = run(points);
  const Status packed =
      packer_.pack(surfaces_.drafts(), surfaces_.cells(), {}, 1200, bytes, places, report);
  const test::HeapGuardTotals totals = HeapGuard::this_thread();
  HeapGuard::disarm_this_thread();
  EXPECT_EQ(found, Status::kOk);
  EXPECT_EQ(packed, Status::kOk);
  EXPECT_EQ(totals.sum(), 0U) << HeapGuard::first_offender();
}

TEST_P(PointSurfacesTest, RefusesMorePointsThanItHasMemoryFor) {
  EXPECT_EQ(run(std::vector<Point3f>(kMost + 1)), Status::kFrameTooLarge);
  EXPECT_EQ(surfaces_.segment(std::vector<Point3f>(3), options_), Status::kWrongSize);
}

INSTANTIATE_TEST_SUITE_P(Methods, PointSurfacesTest,
                         ::testing::Values(PointMethod::kVoxels, PointMethod::kPaper));

}  // namespace
}  // namespace planecast
