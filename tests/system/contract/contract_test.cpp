// The error contract as a property: random rooms, sensors, poses, tolerances and slices through
// the four stages and back, every point checked against its own bound.
#include <gtest/gtest.h>

#include <algorithm>

#include "core/base/random.hpp"
#include "core/sim/random_scene.hpp"
#include "tests/core/pipeline/codec_bench.hpp"
#include "tests/system/contract/contract_check.hpp"

namespace planecast {
namespace {

using namespace test;

double between(Pcg32& random, double low, double high) {
  return low + (high - low) * random.uniform();
}

/// Frames of one sensor in one scene, with what a real sensor does at its worst: readings at both
/// ends of the range, and counts that come from nowhere.
struct Recorded {
  StreamConfig config;
  std::vector<std::vector<std::uint16_t>> frames;
};

Recorded record(const SimConfig& sim, const SimScene& scene, Pcg32& random, int count) {
  auto simulator = RoomSimulator::create(sim, scene);
  EXPECT_TRUE(simulator.ok());
  Recorded out;
  DepthImage image;
  std::vector<std::uint16_t> ids;
  Pose pose;
  for (int i = 0; i < count; ++i) {
    simulator->render(random.below(1000), image, ids, pose);
    if (i == 0) out.config = stream_of(*simulator, image.depth);
    if (random.below(2) == 0) {
      for (std::uint16_t& d : image.depth) {
        if (random.below(200) != 0) continue;
        constexpr std::uint16_t kEnds[] = {65535, 65534, 1, 2};
        d = random.below(2) == 0 ? kEnds[random.below(4)]
                                 : static_cast<std::uint16_t>(random.below(65536));
      }
    }
    out.frames.push_back(image.depth);
  }
  EXPECT_EQ(to_fixed(pose, out.config.pose), Status::kOk);
  return out;
}

/// A stream's settings at random: every tolerance, both off-surface modes.
void any_tolerance(Pcg32& random, StreamConfig& config) {
  if (config.noise.kind == NoiseModel::Kind::kUnknown)
    config.noise = {NoiseModel::Kind::kTof, 1'000'000 + random.below(20'000'000)};
  StreamCase c{"any"};
  switch (random.below(4)) {
    case 0:
      break;
    case 1:
      c.tolerance = ToleranceKind::kMetres;
      c.value = 0.0005 * std::pow(400.0, random.uniform());
      break;
    case 2:
      c.tolerance = ToleranceKind::kSigma;
      c.value = between(random, 0.5, 5);
      break;
    default:
      c.tolerance = ToleranceKind::kSurfaces;
      c.value = between(random, 0.5, 5);
      c.drop = random.below(2) == 0;
  }
  set_case(c, config);
  config.effort_best = random.below(4) == 0;
}

void any_stages(Pcg32& random, StageOptions& stages) {
  constexpr std::size_t kSlices[] = {kMinSliceBytes, 600, 1190, 1190, 8000, kFileSliceBytes};
  stages.slice_bytes = kSlices[random.below(6)];
  if (random.below(3) == 0) {
    stages.range_min = static_cast<std::uint16_t>(random.below(1500));
    stages.range_max = static_cast<std::uint16_t>(2000 + random.below(60000));
  }
  stages.drop_outliers = random.below(3) == 0;
  stages.surfaces = random.below(8) != 0;
}

std::string describe(const EncoderConfig& config) {
  const StreamConfig& s = config.stream;
  return std::to_string(s.camera.width) + "x" + std::to_string(s.camera.height) + " unit " +
         std::to_string(s.camera.unit_pm) + " pm, " + to_string(s.noise) + ", lattice C " +
         std::to_string(s.lattice.c_q8) + "/256, tolerance kind " +
         std::to_string(static_cast<int>(s.tolerance)) + " " + std::to_string(s.tolerance_100nm) +
         " (0.1 um) " + std::to_string(s.sigmas_q16 / 65536.0) + " sigma, drop " +
         std::to_string(s.drop_off_surface) + ", slices " +
         std::to_string(config.stages.slice_bytes);
}

/// Encodes and decodes all frames under one configuration and checks each.
void check_frames(const EncoderConfig& config,
                  const std::vector<std::vector<std::uint16_t>>& frames) {
  SCOPED_TRACE(describe(config));
  const auto encoder = make_encoder(config);
  ASSERT_NE(encoder, nullptr);
  const auto decoder = make_decoder({{config.stream.camera.width, config.stream.camera.height}});
  ASSERT_EQ(decoder->set_key(key_of(*encoder)), Status::kOk);
  ASSERT_EQ(decoder->config(), config.stream);
  for (std::uint64_t i = 0; i < frames.size(); ++i) {
    ASSERT_EQ(encoder->submit(DepthView{frames[i], i, 0}), Status::kOk);
    const auto coded = take_all(*encoder);
    ASSERT_EQ(coded.size(), 1U);
    ASSERT_EQ(coded[0].status, Status::kOk);
    for (const auto& slice : coded[0].slices) ASSERT_LE(slice.size(), config.stages.slice_bytes);
    decode_frame(*decoder, coded[0]);
    const ContractReport report = check_contract(*decoder, config.stages, frames[i]);
    ASSERT_EQ(report.broken, 0U) << report.first_broken << ", worst " << report.worst_share
                                 << " of its bound";
    expect_balance(coded[0].counts, report, config.stream, config.stages);
  }
}

void check_seed(std::uint64_t seed, const SimConfig& sim, const SimScene& scene, int settings) {
  Pcg32 random(seed, 4242);
  const Recorded recorded = record(sim, scene, random, 2);
  for (int i = 0; i < settings; ++i) {
    EncoderConfig config;
    config.stream = recorded.config;
    config.runner = {.slots = 1, .mode = RunMode::kInline};
    any_tolerance(random, config.stream);
    any_stages(random, config.stages);
    check_frames(config, recorded.frames);
    if (testing::Test::HasFatalFailure()) return;
  }
}

// Each kind of breach is planted in what the checker believes was submitted.
TEST(ContractChecker, SeesPointsBeyondTheirBoundFilledHolesAndKeptGatedReadings) {
  SimStream stream = sim_stream(96, 72, 1);
  const EncoderConfig config = encoder_config(stream, kStreamCases[1]);  // 10 mm
  const auto encoder = make_encoder(config);
  const auto decoder = make_decoder();
  ASSERT_EQ(decoder->set_key(key_of(*encoder)), Status::kOk);
  std::vector<std::uint16_t> depth = stream.frames[0];
  ASSERT_EQ(encoder->submit(DepthView{depth, 0, 0}), Status::kOk);
  decode_frame(*decoder, take_all(*encoder).at(0));
  ASSERT_EQ(check_contract(*decoder, config.stages, depth).broken, 0U);

  const auto reading = static_cast<std::size_t>(
      std::ranges::find_if(depth, [](auto d) { return d > 500; }) - depth.begin());
  const auto broken = [&](std::uint16_t instead) {
    std::vector<std::uint16_t> other = depth;
    other[reading] = instead;
    return check_contract(*decoder, config.stages, other).broken;
  };
  EXPECT_EQ(broken(static_cast<std::uint16_t>(depth[reading] + 25)), 1U);
  EXPECT_EQ(broken(static_cast<std::uint16_t>(depth[reading] - 25)), 1U);
  EXPECT_EQ(broken(0), 1U);
  StageOptions narrow = config.stages;
  narrow.range_min = static_cast<std::uint16_t>(depth[reading] + 1);
  EXPECT_GT(check_contract(*decoder, narrow, depth).broken, 0U);
}

TEST(Contract, HoldsForEveryPointOfRandomScenesSensorsAndTolerances) {
  constexpr std::uint64_t kSeeds = kSanitized ? 30 : 150;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    SCOPED_TRACE("scene " + std::to_string(seed));
    const RandomScene scene = random_scene(seed);
    check_seed(seed, scene.config, scene.scene, 2);
    if (HasFatalFailure()) return;
  }
}

TEST(Contract, HoldsForEveryPointOfEveryPreset) {
  std::uint64_t seed = 1000;
  for (const SensorPreset& preset : sensor_presets()) {
    SCOPED_TRACE(std::string(preset.name));
    SimConfig sim = sim_config(preset);
    const double scale = kSanitized ? 0.25 : 0.5;  // the sensor's angles, fewer pixels
    sim.width = static_cast<std::uint32_t>(sim.width * scale);
    sim.height = static_cast<std::uint32_t>(sim.height * scale);
    Intrinsics& in = sim.intrinsics;
    for (double* value : {&in.fx, &in.fy, &in.cx, &in.cy}) *value *= scale;
    sim.seed = ++seed;
    check_seed(seed, sim, random_scene(seed).scene, kSanitized ? 2 : 4);
    if (HasFatalFailure()) return;
  }
}

// Every pair of neighbouring counts, both extremes and noise: nothing a depth image can hold may
// come back changed.
TEST(Contract, LosslessIsBitExactForAnyCounts) {
  Pcg32 random(8, 8);
  EncoderConfig config;
  Intrinsics in;
  in.fx = in.fy = 200;
  in.cx = 128;
  in.cy = 64;
  config.stream.camera = *quantise(in, 256, 256);
  config.stream.noise = {NoiseModel::Kind::kStereo, 3'000'000};
  config.runner = {.slots = 1, .mode = RunMode::kInline};
  std::vector<std::vector<std::uint16_t>> frames(5, std::vector<std::uint16_t>(65536));
  for (std::uint32_t i = 0; i < 65536; ++i) {
    frames[0][i] = static_cast<std::uint16_t>(i);
    frames[1][i] = static_cast<std::uint16_t>(random.next());
    frames[2][i] = random.below(2) == 0 ? 65535 : 0;
    frames[3][i] = 65535;
    frames[4][i] = static_cast<std::uint16_t>(32000 + (i % 256) * 3 + (i / 256) * 5);
  }
  for (const std::uint32_t c_q8 : {0U, 512U, 9'600'000U, 2'000'000'000U}) {
    for (const std::size_t slice_bytes : {kMinSliceBytes, std::size_t{1190}, kFileSliceBytes}) {
      config.stream.lattice = {c_q8, 0, false};
      config.stages.slice_bytes = slice_bytes;
      check_frames(config, frames);
      if (HasFatalFailure()) return;
    }
  }
}

}  // namespace
}  // namespace planecast
