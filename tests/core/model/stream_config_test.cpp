// What check_config lets through, and every way in which it refuses.
#include "core/model/stream_config.hpp"

#include <gtest/gtest.h>

#include <functional>

#include "tests/core/model/random_config.hpp"

namespace planecast {
namespace {

StreamConfig good_config() {
  Pcg32 random(1);
  StreamConfig c;
  c.camera = test::random_camera(random, 64, 48, 1.0, false);
  return c;
}

TEST(StreamConfig, DefaultsWithACameraAreAccepted) {
  EXPECT_EQ(check_config(good_config()), Status::kOk);
}

TEST(StreamConfig, RandomValidConfigurationsAreAccepted) {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    Pcg32 random(seed);
    EXPECT_EQ(check_config(test::random_config(random)), Status::kOk) << seed;
  }
}

TEST(StreamConfig, EveryFieldOutOfRangeIsRefused) {
  const std::vector<std::pair<const char*, std::function<void(StreamConfig&)>>> faults = {
      {"kind", [](StreamConfig& c) { c.kind = static_cast<FrameKind>(3); }},
      {"z_rule", [](StreamConfig& c) { c.z_rule = static_cast<ZRule>(3); }},
      {"clock", [](StreamConfig& c) { c.clock = static_cast<ClockDomain>(4); }},
      {"tolerance", [](StreamConfig& c) { c.tolerance = static_cast<ToleranceKind>(4); }},
      {"noise", [](StreamConfig& c) { c.noise.kind = static_cast<NoiseModel::Kind>(3); }},
      {"period", [](StreamConfig& c) { c.period_ms = 0; }},
      {"width", [](StreamConfig& c) { c.camera.width = 0; }},
      {"width above", [](StreamConfig& c) { c.camera.width = kMaxImageSide + 1; }},
      {"height", [](StreamConfig& c) { c.camera.height = 0; }},
      {"height above", [](StreamConfig& c) { c.camera.height = kMaxImageSide + 1; }},
      {"fx", [](StreamConfig& c) { c.camera.fx_q16 = 0; }},
      {"fy", [](StreamConfig& c) { c.camera.fy_q16 = 0; }},
      {"ray beyond 8", [](StreamConfig& c) { c.camera.fx_q16 = 65536; }},
      {"centre", [](StreamConfig& c) { c.camera.cy_q16 = 0x7fffffff; }},
      {"unit", [](StreamConfig& c) { c.camera.unit_pm = 0; }},
      {"unit above", [](StreamConfig& c) { c.camera.unit_pm = kMaxUnitPm + 1; }},
      {"lattice", [](StreamConfig& c) { c.lattice.c_q8 = kMinLatticeCQ8 - 1; }},
      {"lattice offset", [](StreamConfig& c) { c.lattice.offset_q16 = 65536; }},
      {"sigmas", [](StreamConfig& c) { c.tolerance = ToleranceKind::kSigma; }},
      {"surfaces", [](StreamConfig& c) { c.tolerance = ToleranceKind::kSurfaces; }},
      {"drop", [](StreamConfig& c) { c.drop_off_surface = true; }},
      {"name", [](StreamConfig& c) { c.frame_id[0] = '\n'; }},
      {"name not ASCII", [](StreamConfig& c) { c.frame_id[0] = '\xc3'; }},
      {"name after its end", [](StreamConfig& c) { c.frame_id[4] = 'a'; }},
      {"name without end", [](StreamConfig& c) { c.frame_id.fill('a'); }},
      {"pose norm", [](StreamConfig& c) { c.pose.q_q30[1] = 1 << 20; }},
      {"pose sign",
       [](StreamConfig& c) {
         c.pose.q_q30 = {-(1 << 30), 0, 0, 0};
       }},
      {"pose zero",
       [](StreamConfig& c) {
         c.pose.q_q30 = {0, 0, 0, 0};
       }},
      {"translation", [](StreamConfig& c) { c.pose.t_um[2] = kMaxTranslationUm + 1; }},
      {"axes norm", [](StreamConfig& c) { c.axes.q_q30[0] = 1 << 29; }},
      {"axes translation", [](StreamConfig& c) { c.axes.t_um[0] = -kMaxTranslationUm - 1; }},
      {"points of a camera's stream", [](StreamConfig& c) { c.points.max_points = 1; }},
  };
  for (const auto& [name, spoil] : faults) {
    StreamConfig c = good_config();
    spoil(c);
    EXPECT_EQ(check_config(c), Status::kFieldRange) << name;
  }
}

StreamConfig good_points() {
  StreamConfig c;
  c.kind = FrameKind::kPoints;
  c.points = {1000, 100'000'000, 99, 390'625, FillMode::kRandom, 7};
  c.tolerance = ToleranceKind::kMetres;
  c.tolerance_100nm = 100'000;
  c.noise = {NoiseModel::Kind::kTof, 4'000'000};
  c.axes.t_um = {500'000'000'000, 5'400'000'000'000, 0};
  return c;
}

TEST(StreamConfig, EveryFieldOfAPointsStreamOutOfRangeIsRefused) {
  const std::vector<std::pair<const char*, std::function<void(StreamConfig&)>>> faults = {
      {"no points", [](StreamConfig& c) { c.points.max_points = 0; }},
      {"too many", [](StreamConfig& c) { c.points.max_points = kMaxFramePoints + 1; }},
      {"step", [](StreamConfig& c) { c.points.step_pm = kMaxPointStepPm + 1; }},
      {"bound above", [](StreamConfig& c) { c.points.tolerance_steps = 101; }},
      {"patch unit", [](StreamConfig& c) { c.points.patch_unit_nm = 0; }},
      {"patch unit above", [](StreamConfig& c) { c.points.patch_unit_nm = kMaxPatchUnitNm + 1; }},
      {"a bound without a grid", [](StreamConfig& c) { c.points.step_pm = 0; }},
      {"fill", [](StreamConfig& c) { c.points.fill = static_cast<FillMode>(2); }},
      {"camera", [](StreamConfig& c) { c.camera.width = 1; }},
      {"lattice", [](StreamConfig& c) { c.lattice.c_q8 = kMinLatticeCQ8; }},
      {"z_rule", [](StreamConfig& c) { c.z_rule = ZRule::kPrinted7; }},
      {"mirror", [](StreamConfig& c) { c.mirror_y = true; }},
      {"turned axes",
       [](StreamConfig& c) {
         c.axes.q_q30 = {0, 1 << 30, 0, 0};
       }},
      {"sigma of stereo",
       [](StreamConfig& c) {
         c.tolerance = ToleranceKind::kSigma;
         c.sigmas_q16 = 1;
         c.noise.kind = NoiseModel::Kind::kStereo;
       }},
  };
  EXPECT_EQ(check_config(good_points()), Status::kOk);
  for (const auto& [name, spoil] : faults) {
    StreamConfig c = good_points();
    spoil(c);
    EXPECT_EQ(check_config(c), Status::kFieldRange) << name;
  }
}

TEST(StreamConfig, TheBoundOfPointsIsInPicometresWhateverTheTolerance) {
  StreamConfig c = good_points();
  EXPECT_EQ(point_bound_pm(c), 10'000'000'000U);
  c.tolerance = ToleranceKind::kLossless;
  EXPECT_EQ(point_bound_pm(c), 0U);
  c.tolerance = ToleranceKind::kSurfaces;
  c.sigmas_q16 = 5U << 15U;
  EXPECT_EQ(point_bound_pm(c), 10'000'000'000U);
  c.sigmas_q16 = c.noise.s_e9 = 0xffffffffU;  // no overflow
  EXPECT_EQ(point_bound_pm(c), ((std::uint64_t{0xffffffffU} * 0xffffffffU) >> 16U) * 1000);
}

TEST(StreamConfig, TheLongestNameIsAccepted) {
  StreamConfig c = good_config();
  c.frame_id.fill('z');
  c.frame_id[kMaxFrameIdBytes] = 0;
  EXPECT_EQ(check_config(c), Status::kOk);
}

}  // namespace
}  // namespace planecast
