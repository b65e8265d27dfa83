// Depth frames through packer and unpacker: every point within its bound by double arithmetic,
// holes stay holes, lossless is exact, whatever the image, size, contract, lattice and surfaces.
#include <gtest/gtest.h>

#include "core/regen/regenerate.hpp"
#include "core/sim/random_scene.hpp"
#include "core/sim/sim_room.hpp"
#include "tests/core/predict/bound_oracle.hpp"
#include "tests/core/wire/wire_bench.hpp"
#include "tests/support/sanitized.hpp"

namespace planecast {
namespace {

using test::Bytes;
using test::Image;
using test::SurfaceMode;
using test::WireBench;

void expect_kept(const WireBench& b, const Image& in, const Image& out) {
  ASSERT_EQ(in.size(), out.size());
  if (b.config.tolerance == ToleranceKind::kLossless) {
    ASSERT_EQ(in, out);
    return;
  }
  const RayTable& rays = b.tables.rays();
  for (std::uint32_t v = 0, i = 0; v < rays.height; ++v) {
    for (std::uint32_t u = 0; u < rays.width; ++u, ++i) {
      ASSERT_EQ(in[i] == 0, out[i] == 0) << u << "," << v;
      if (in[i] == out[i]) continue;
      const double off = test::distance(test::exact_point(b.config, rays, u, v, in[i]),
                                        test::float_point(b.config, rays, u, v, out[i]));
      ASSERT_LE(off, test::bound_m(b.config, in[i]))
          << u << "," << v << ": " << in[i] << " became " << out[i];
    }
  }
}

void expect_round_trip(WireBench& b, const Image& image, std::size_t slice_bytes) {
  const auto packets = b.pack(image, slice_bytes);
  const Image out = b.unpack_all(packets);
  expect_kept(b, image, out);
  std::uint32_t points = 0, corrections = 0;
  for (const TileContent& content : b.contents) {
    points += content.points;
    corrections += content.corrections;
  }
  EXPECT_EQ(points, b.report.points);
  EXPECT_EQ(points,
            image.size() - static_cast<std::size_t>(std::count(image.begin(), image.end(), 0)));
  // Verbatim tiles count none.
  EXPECT_LE(corrections, b.report.corrections);
}

std::size_t some_slice_bytes(Pcg32& random) {
  constexpr std::size_t kSizes[] = {kMinSliceBytes, 300, 1190, 1190, 4000, kFileSliceBytes};
  return kSizes[random.below(6)];
}

TEST(TileRoundTrip, EveryImageKindContractAndSurfaceModeKeepsItsBound) {
  for (std::uint64_t seed = 0; seed < 324; ++seed) {
    SCOPED_TRACE(seed);
    Pcg32 random(seed);
    StreamConfig config = test::random_config(random, 97);
    WireBench b(config);
    const Image image = test::random_image(random, config.camera, seed);
    b.find_surfaces(image, static_cast<SurfaceMode>(seed / test::kImageKinds % 3), random);
    expect_round_trip(b, image, some_slice_bytes(random));
    if (HasFatalFailure()) return;
  }
}

TEST(TileRoundTrip, EverySizeFromOnePixelUpKeepsItsBound) {
  std::uint64_t seed = 1000;
  for (const std::uint32_t width : {1U, 2U, 7U, 8U, 9U, 16U, 17U, 33U, 64U, 65U}) {
    for (const std::uint32_t height : {1U, 5U, 8U, 9U, 24U, 65U}) {
      SCOPED_TRACE(std::to_string(width) + " x " + std::to_string(height));
      Pcg32 random(++seed);
      StreamConfig config = test::random_config(random, 4);
      config.camera = test::random_camera(random, width, height, 1.5, true);
      WireBench b(config);
      for (std::uint64_t kind = 0; kind < test::kImageKinds; kind += 1 + random.below(3)) {
        const Image image = test::random_image(random, config.camera, kind);
        b.find_surfaces(image, static_cast<SurfaceMode>(random.below(3)), random);
        expect_round_trip(b, image, some_slice_bytes(random));
        if (HasFatalFailure()) return;
      }
    }
  }
}

TEST(TileRoundTrip, LosslessGivesEveryCountBackAlsoOffTheLattice) {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    SCOPED_TRACE(seed);
    Pcg32 random(seed);
    StreamConfig config;
    config.camera = test::random_camera(random, 50 + random.below(40), 40, 1.5, true);
    config.lattice = {200'000U * 256U, 0, seed % 2 == 0};
    if (seed % 5 == 0) config.lattice = {kMinLatticeCQ8 + random.below(70000), 40000, false};
    WireBench b(config);
    Image image = test::random_image(random, config.camera, seed);
    for (auto& d : image) {
      const std::uint64_t level = lattice_depth(config.lattice, 1 + d / 64U);
      if (d != 0 && level < 65536 && random.below(5) != 0) d = static_cast<std::uint16_t>(level);
      if (random.below(200) == 0) d = 65535;
    }
    b.find_surfaces(image, static_cast<SurfaceMode>(seed % 3), random);
    expect_round_trip(b, image, 1190);
    if (HasFatalFailure()) return;
  }
}

TEST(TileRoundTrip, SimulatedScenesKeepTheirBoundUnderEveryContract) {
  int done = 0;
  for (std::uint64_t seed = 0; done < 24; ++seed) {
    const RandomScene scene = random_scene(seed);
    if (scene.config.width * scene.config.height > 100'000) continue;
    SCOPED_TRACE(seed);
    ++done;
    auto simulator = RoomSimulator::create(scene.config, scene.scene);
    ASSERT_TRUE(simulator.ok()) << simulator.error().message;
    DepthImage image;
    std::vector<std::uint16_t> ids;
    Pose pose;
    simulator->render(seed, image, ids, pose);
    Pcg32 random(seed);
    for (int contract = 0; contract < 4; ++contract) {
      StreamConfig config;
      config.camera = simulator->camera();
      config.tolerance = static_cast<ToleranceKind>(contract);
      config.tolerance_100nm = 50'000 + random.below(300'000);
      config.sigmas_q16 = 32768 + random.below(4U << 16U);
      config.effort_best = seed % 3 == 0;
      config.noise = {seed % 2 == 0 ? NoiseModel::Kind::kStereo : NoiseModel::Kind::kTof,
                      4'000'000};
      WireBench b(config);
      b.find_surfaces(image.depth, contract == 0 ? SurfaceMode::kNone : SurfaceMode::kFitted,
                      random);
      expect_round_trip(b, image.depth, contract % 2 == 0 ? 1190 : kFileSliceBytes);
      if (HasFatalFailure()) return;
    }
  }
}

TEST(TileRoundTrip, TilesThatNoTimeIsLeftForKeepTheirBound) {
  for (std::uint64_t seed = 0; seed < (test::kSanitized ? 60 : 216); ++seed) {
    SCOPED_TRACE(seed);
    Pcg32 random(seed);
    StreamConfig config = test::random_config(random, 97);
    WireBench b(config);
    b.deadline = test::past_deadline();
    const Image image = test::random_image(random, config.camera, seed);
    b.find_surfaces(image, static_cast<SurfaceMode>(seed % 3), random);
    expect_round_trip(b, image, some_slice_bytes(random));
    if (HasFatalFailure()) return;
    for (const TileContent& content : b.contents) EXPECT_TRUE(content.runs || content.verbatim);
    EXPECT_EQ(b.report.run_tiles, b.report.slices);
  }
}

TEST(TileRoundTrip, RunsCostLessThanCountsOfAScene) {
  auto simulator = RoomSimulator::create(default_sim_config());
  ASSERT_TRUE(simulator.ok()) << simulator.error().message;
  DepthImage image;
  std::vector<std::uint16_t> ids;
  Pose pose;
  simulator->render(1, image, ids, pose);
  for (const ToleranceKind kind : {ToleranceKind::kLossless, ToleranceKind::kSigma}) {
    StreamConfig config;
    config.camera = simulator->camera();
    config.tolerance = kind;
    config.tolerance_100nm = 50'000;
    config.sigmas_q16 = 2U << 16U;
    config.noise = {NoiseModel::Kind::kStereo, 4'000'000};
    WireBench b(config);
    (void)b.pack(image.depth, kFileSliceBytes);
    const std::size_t modelled = b.report.bytes;
    b.deadline = test::past_deadline();
    (void)b.pack(image.depth, kFileSliceBytes);
    EXPECT_LT(b.report.bytes, image.depth.size() * 2 * 2 / 3);
    EXPECT_LT(modelled, b.report.bytes);
  }
}

TEST(TileRoundTrip, RegeneratedCloudsOfBothEndsKeepTheBound) {
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    SCOPED_TRACE(seed);
    Pcg32 random(seed);
    StreamConfig config = test::random_config(random, 60);
    config.axes = {};
    config.mirror_y = false;
    WireBench b(config);
    const Image image = test::random_image(random, config.camera, seed);
    const Image out = b.unpack_all(b.pack(image, 1190));
    std::vector<Point3f> sent(image.size()), got(image.size());
    ASSERT_EQ(regenerate(b.config, b.tables.rays(), b.tables.scale(), image, sent), Status::kOk);
    ASSERT_EQ(regenerate(b.config, b.tables.rays(), b.tables.scale(), out, got), Status::kOk);
    for (std::size_t i = 0; i < image.size(); ++i) {
      if (image[i] == out[i]) continue;
      ASSERT_LE(test::distance({sent[i].x, sent[i].y, sent[i].z}, {got[i].x, got[i].y, got[i].z}),
                test::bound_m(b.config, image[i]));
    }
  }
}

TEST(TileRoundTrip, AFlatWallCostsNextToNothingAndNoiseNoMoreThanItsCounts) {
  Pcg32 random(77);
  StreamConfig config;
  config.camera = test::random_camera(random, 320, 240, 1.0, false);
  WireBench b(config);
  (void)b.pack(Image(config.camera.pixels(), 2000), kFileSliceBytes);
  EXPECT_LT(b.report.bytes, 200U);
  const Image noise = test::random_image(random, config.camera, 1);
  (void)b.pack(noise, kFileSliceBytes);
  EXPECT_LE(b.report.bytes, noise.size() * 2 + b.report.slices * 40);
  (void)b.pack(Image(config.camera.pixels(), 0), kFileSliceBytes);
  EXPECT_LT(b.report.bytes, 80U);
}

TEST(TileRoundTrip, TheSameFramesGiveTheSameBytes) {
  Pcg32 random(78);
  StreamConfig config = test::random_config(random, 120);
  WireBench a(config), b(config);
  for (std::uint64_t frame = 0; frame < 6; ++frame) {
    const Image image = test::random_image(random, config.camera, frame);
    EXPECT_EQ(a.pack(image, 1190), b.pack(image, 1190));
  }
}

}  // namespace
}  // namespace planecast
