// Tiles of `--effort best`: fewer bytes than fast ones for the same bound, in slices and in files;
// what was mixed comes back the same; and what no encoder says is refused.
#include <gtest/gtest.h>

#include <cmath>

#include "core/sim/sim_room.hpp"
#include "core/wire/mix_bit.hpp"
#include "tests/core/wire/wire_bench.hpp"
#include "tests/support/sanitized.hpp"

namespace planecast {
namespace {

using test::Image;
using test::SurfaceMode;
using test::WireBench;

// A frame of a random room and its stream.
struct Scene {
  StreamConfig config;
  Image image;

  Scene(std::uint64_t seed, ToleranceKind kind, bool with_lattice = true) {
    SimConfig sim = default_sim_config();
    sim.seed = seed;
    sim.width = 160;
    sim.height = 120;
    sim.intrinsics.fx /= 4;
    sim.intrinsics.fy /= 4;
    sim.intrinsics.cx = 80;
    sim.intrinsics.cy = 60;
    auto simulator = RoomSimulator::create(sim);
    EXPECT_TRUE(simulator.ok());
    DepthImage depth;
    std::vector<std::uint16_t> ids;
    Pose pose;
    simulator->render(seed, depth, ids, pose);
    image = depth.depth;
    config.camera = simulator->camera();
    config.noise = sim.noise;
    const double c =
        sim.intrinsics.fx * sim.baseline_m * sim.steps_per_pixel / sim.intrinsics.metres_per_unit;
    if (with_lattice) config.lattice = {static_cast<std::uint32_t>(std::lround(c * 256)), 0, false};
    config.tolerance = kind;
    config.sigmas_q16 = 2U << 16U;
    config.tolerance_100nm = 200'000;
  }
};

std::size_t bytes_of(const Scene& scene, bool best, std::size_t slice_bytes) {
  StreamConfig config = scene.config;
  config.effort_best = best;
  WireBench b(config);
  Pcg32 random(1);
  b.find_surfaces(scene.image, SurfaceMode::kFitted, random);
  const auto packets = b.pack(scene.image, slice_bytes);
  const Image out = b.unpack_all(packets);
  for (std::size_t i = 0; i < out.size(); ++i) EXPECT_EQ(out[i] == 0, scene.image[i] == 0);
  EXPECT_TRUE(config.tolerance != ToleranceKind::kLossless || out == scene.image);
  return b.report.bytes;
}

TEST(MixTile, CostsLessThanFastUnderEveryContract) {
  PLANECAST_NEED_SPEED();
  for (const auto kind : {ToleranceKind::kLossless, ToleranceKind::kMetres, ToleranceKind::kSigma,
                          ToleranceKind::kSurfaces}) {
    SCOPED_TRACE(static_cast<int>(kind));
    std::size_t fast = 0, best = 0, fast_slices = 0, best_slices = 0;
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
      const Scene scene(seed, kind);
      fast += bytes_of(scene, false, kFileSliceBytes);
      best += bytes_of(scene, true, kFileSliceBytes);
      fast_slices += bytes_of(scene, false, 1190);
      best_slices += bytes_of(scene, true, 1190);
    }
    EXPECT_LT(best, fast);
    // Lossless a slice of a frame this small is too short for mixing to learn more than shapes
    // know from training: most tiles are plain, and say so with a bit.
    EXPECT_LT(best_slices,
              fast_slices + (kind == ToleranceKind::kLossless ? fast_slices / 500 : 0));
  }
}

TEST(MixTile, CostsHardlyMoreThanFastWhereBlendingFails) {
  for (const auto kind : {ToleranceKind::kLossless, ToleranceKind::kSigma}) {
    const Scene scene(7, kind, false);  // readings on a lattice that nobody told of
    for (const std::size_t slice_bytes : {std::size_t{1190}, kFileSliceBytes}) {
      const double fast = static_cast<double>(bytes_of(scene, false, slice_bytes));
      EXPECT_LE(static_cast<double>(bytes_of(scene, true, slice_bytes)), fast * 1.02);
    }
  }
}

TEST(MixTile, APlaneIsForetoldWhateverItsSlope) {
  StreamConfig config = Scene(1, ToleranceKind::kLossless, false).config;
  config.effort_best = true;
  config.noise = {};
  WireBench b(config);
  const CameraModel& camera = config.camera;
  Image image(camera.pixels());
  for (std::uint32_t v = 0, i = 0; v < camera.height; ++v) {
    for (std::uint32_t u = 0; u < camera.width; ++u, ++i)
      image[i] = static_cast<std::uint16_t>(2000 + 3 * u + 5 * v);
  }
  const auto packets = b.pack(image, kFileSliceBytes);
  EXPECT_EQ(b.unpack_all(packets), image);
  EXPECT_LT(b.report.bytes * 8, image.size() / 20);  // the first rows and columns only
}

TEST(MixedDecision, LearnsWhichModelToTrust) {
  MixedModel told, noise;
  MixWeights<2> weights{{20000, 20000}, 0};
  Pcg32 random(3);
  double bits = 0;
  for (int i = 0; i < 4000; ++i) {
    const bool bit = random.below(16) == 0;
    // One model hears the truth, the other a coin.
    MixedModel* const models[2] = {&told, &noise};
    const MixedDecision<2> mixed(weights, models);
    const double p = mixed.probability / 65536.0;
    if (i >= 1000) bits -= std::log2(bit ? p : 1 - p);
    mixed.learn(weights, models, bit);
    noise.update(random.below(2) == 0);
  }
  const double entropy = -(std::log2(1 / 16.0) / 16 + 15 * std::log2(15 / 16.0) / 16);
  EXPECT_LT(bits / 3000, entropy * 1.08);
}

TEST(MixedDecision, ProbabilitiesStayOffTheEnds) {
  MixedModel models_of[8];
  MixedModel* models[8];
  for (int i = 0; i < 8; ++i) models[i] = &models_of[i];
  MixWeights<8> weights;
  std::fill_n(weights.weight, 8, MixWeights<8>::kMost);
  for (int i = 0; i < 20000; ++i) {
    const MixedDecision<8> mixed(weights, models);
    ASSERT_GE(mixed.probability, 32U);
    ASSERT_LE(mixed.probability, 65504U);
    mixed.learn(weights, models, i < 10000);
  }
}

}  // namespace
}  // namespace planecast
