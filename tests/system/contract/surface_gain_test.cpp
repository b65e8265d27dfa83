// Surfaces are an offer to the coder, which takes the cheaper way by an estimate of its cost: they
// must save bytes on the whole and hardly ever cost any.
#include <gtest/gtest.h>

#include <algorithm>

#include "core/sim/random_scene.hpp"
#include "tests/core/pipeline/codec_bench.hpp"

namespace planecast {
namespace {

using namespace test;

/// Contracts under which surfaces and neighbours compete.
constexpr StreamCase kContests[] = {
    {"lossless"},
    {"2 mm", FrameKind::kDepth, ToleranceKind::kMetres, 0.002},
    {"20 mm", FrameKind::kDepth, ToleranceKind::kMetres, 0.020},
    {"1 sigma", FrameKind::kDepth, ToleranceKind::kSigma, 1},
    {"2 sigma", FrameKind::kDepth, ToleranceKind::kSigma, 2},
    {"4 sigma", FrameKind::kDepth, ToleranceKind::kSigma, 4},
};

/// Packed bytes of one frame, coded both ways.
struct Pair {
  std::string name;
  std::size_t without = 0, with = 0;
  double growth() const { return static_cast<double>(with) / static_cast<double>(without) - 1; }
};

std::size_t packed_bytes(EncoderConfig config, const std::vector<std::uint16_t>& depth,
                         bool surfaces) {
  config.stages.surfaces = surfaces;
  const auto encoder = make_encoder(config);
  EXPECT_EQ(encoder->submit(DepthView{depth, 0, 0}), Status::kOk);
  std::size_t bytes = 0;
  for (const Coded& coded : take_all(*encoder)) {
    for (const auto& slice : coded.slices) bytes += slice.size();
  }
  return bytes;
}

/// Codes one frame of a sensor in a scene under each contract.
void contest(const std::string& name, const SimConfig& sim, const SimScene& scene,
             std::vector<Pair>& out) {
  auto simulator = RoomSimulator::create(sim, scene);
  ASSERT_TRUE(simulator.ok());
  DepthImage image;
  std::vector<std::uint16_t> ids;
  Pose pose;
  simulator->render(7, image, ids, pose);
  EncoderConfig config;
  config.runner = {.slots = 1, .mode = RunMode::kInline};
  config.stream = stream_of(*simulator, image.depth);
  if (config.stream.noise.kind == NoiseModel::Kind::kUnknown)
    config.stream.noise = {NoiseModel::Kind::kTof, 5'000'000};
  for (const StreamCase& c : kContests) {
    set_case(c, config.stream);
    out.push_back({name + ", " + c.name, packed_bytes(config, image.depth, false),
                   packed_bytes(config, image.depth, true)});
  }
}

/// Bytes of all pairs together.
Pair sum_of(const std::vector<Pair>& pairs) {
  Pair sum;
  for (const Pair& pair : pairs) {
    sum.without += pair.without;
    sum.with += pair.with;
  }
  return sum;
}

SimConfig of_width(SimConfig sim, std::uint32_t width) {
  const double scale = static_cast<double>(width) / sim.width;
  sim.width = width;
  sim.height = static_cast<std::uint32_t>(sim.height * scale);
  Intrinsics& in = sim.intrinsics;
  for (double* value : {&in.fx, &in.fy, &in.cx, &in.cy}) *value *= scale;
  return sim;
}

TEST(SurfaceGain, RealSensorsSaveOnTheWholeAndNoFrameGrowsByTwoHundredths) {
  if (kSanitized) GTEST_SKIP() << "figures do not depend on a sanitizer";
  std::vector<Pair> all;
  for (const SensorPreset& preset : sensor_presets()) {
    std::vector<Pair> pairs;
    const SimConfig sim = of_width(sim_config(preset), 480);
    contest(std::string(preset.name), sim, room_scene(), pairs);
    for (const Pair& pair : pairs) {
      EXPECT_LT(pair.growth(), 0.02)
          << pair.name << ": " << pair.without << " bytes without surfaces, " << pair.with;
    }
    all.insert(all.end(), pairs.begin(), pairs.end());
  }
  EXPECT_LT(sum_of(all).growth(), 0);
}

// A sensor that says a handful of depths only, too few for a lattice to be found, makes repeating
// the neighbour nearly free, which the estimate does not foresee: coarser than 8 steps a pixel is
// left out. What remains are small frames, where one surface too many shows, and noise of a count
// or two.
TEST(SurfaceGain, RandomScenesSaveOnTheWholeAndFewFramesGrowByAHundredth) {
  if (kSanitized) GTEST_SKIP() << "figures do not depend on a sanitizer";
  constexpr std::uint64_t kSeeds = 60;
  std::vector<Pair> pairs;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const RandomScene scene = random_scene(seed);
    const double steps = scene.config.steps_per_pixel;
    if (steps > 0 && steps < 8) continue;
    contest("scene " + std::to_string(seed), scene.config, scene.scene, pairs);
  }
  EXPECT_LT(sum_of(pairs).growth(), -0.03);
  std::string larger;
  const auto count = std::ranges::count_if(pairs, [&](const Pair& pair) {
    if (pair.growth() <= 0.01) return false;
    larger += pair.name + ": " + std::to_string(pair.without) + " bytes, with surfaces " +
              std::to_string(pair.with) + "\n";
    return true;
  });
  EXPECT_LE(count * 100, std::ssize(pairs) * 4) << "of " << pairs.size() << " pairs:\n" << larger;
}

}  // namespace
}  // namespace planecast
