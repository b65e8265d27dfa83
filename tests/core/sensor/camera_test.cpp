// Quantising a camera: what is kept, what is refused and with which words.
#include "core/sensor/camera.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "core/sensor/sensor_preset.hpp"

namespace planecast {
namespace {

Intrinsics plain() {
  Intrinsics in;
  in.fx = in.fy = 525.0;
  in.cx = 319.5;
  in.cy = 239.5;
  return in;
}

void expect_refused(const Intrinsics& in, std::uint32_t width, std::uint32_t height,
                    const std::string& word) {
  const auto result = quantise(in, width, height);
  ASSERT_FALSE(result.ok()) << word;
  EXPECT_EQ(result.error().status, Status::kBadConfig);
  EXPECT_NE(result.error().message.find(word), std::string::npos) << result.error().message;
}

TEST(Camera, QuantisingIsExactToHalfALastBitAndReversible) {
  Intrinsics in{383.8, 384.2, 321.7, 236.8, -0.05, 0.01, 0.0003, -0.0004, 0.002, 0.00025};
  const auto model = quantise(in, 640, 480);
  ASSERT_TRUE(model.ok());
  const Intrinsics back = to_intrinsics(*model);
  EXPECT_NEAR(back.fx, in.fx, 0.5 / 65536);
  EXPECT_NEAR(back.cy, in.cy, 0.5 / 65536);
  EXPECT_NEAR(back.k1, in.k1, 0.5 / 16777216);
  EXPECT_NEAR(back.p2, in.p2, 0.5 / 16777216);
  EXPECT_EQ(model->unit_pm, 250'000'000U);
  EXPECT_EQ(*quantise(back, 640, 480), *model);
  EXPECT_TRUE(model->distorted());
  EXPECT_EQ(check_camera(*model), Status::kOk);
}

TEST(Camera, RefusesUselessNumbersByName) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  for (const double bad : {0.0, -525.0, nan, inf, 1e9}) {
    Intrinsics in = plain();
    in.fx = bad;
    expect_refused(in, 640, 480, "fx");
    in = plain();
    in.fy = bad;
    expect_refused(in, 640, 480, "fy");
  }
  for (const double bad : {nan, inf, -inf, 1e6}) {
    Intrinsics in = plain();
    in.cx = bad;
    expect_refused(in, 640, 480, "cx");
    in = plain();
    in.k2 = bad;
    expect_refused(in, 640, 480, "k2");
  }
  for (const double bad : {0.0, -0.001, nan, inf, 2.0, 1e-14}) {
    Intrinsics in = plain();
    in.metres_per_unit = bad;
    expect_refused(in, 640, 480, "metres per unit");
  }
  expect_refused(plain(), 0, 480, "width");
  expect_refused(plain(), 640, 0, "height");
  expect_refused(plain(), 16385, 480, "width");
}

TEST(Camera, RefusesAFocalLengthTooShortForTheImage) {
  Intrinsics in = plain();
  in.fx = 30;  // 640 pixels wide: 320 / 30 > 8
  expect_refused(in, 640, 480, "fx");
  in = plain();
  in.cy = -5000;  // rows far off axis
  expect_refused(in, 640, 480, "fy");
}

TEST(Camera, AcceptsTheSmallestAndLargestImages) {
  Intrinsics in = plain();
  EXPECT_TRUE(quantise(in, 1, 1).ok());
  in.fx = in.fy = 12000;
  in.cx = in.cy = 8191.5;
  EXPECT_TRUE(quantise(in, 16384, 16384).ok());
}

TEST(Camera, CheckRefusesWhatQuantiseCouldNotHaveMade) {
  const CameraModel good = *quantise(plain(), 640, 480);
  auto broken = [&](auto change) {
    CameraModel camera = good;
    change(camera);
    return check_camera(camera);
  };
  EXPECT_EQ(check_camera(good), Status::kOk);
  EXPECT_EQ(broken([](CameraModel& c) { c.width = 0; }), Status::kFieldRange);
  EXPECT_EQ(broken([](CameraModel& c) { c.height = 20000; }), Status::kFieldRange);
  EXPECT_EQ(broken([](CameraModel& c) { c.fx_q16 = 0; }), Status::kFieldRange);
  EXPECT_EQ(broken([](CameraModel& c) { c.fy_q16 = 1; }), Status::kFieldRange);
  EXPECT_EQ(broken([](CameraModel& c) { c.unit_pm = 0; }), Status::kFieldRange);
  EXPECT_EQ(broken([](CameraModel& c) { c.unit_pm = kMaxUnitPm + 1; }), Status::kFieldRange);
  EXPECT_EQ(broken([](CameraModel& c) { c.cx_q16 = std::numeric_limits<std::int32_t>::min(); }),
            Status::kFieldRange);
}

TEST(SensorPreset, EveryPresetIsSane) {
  EXPECT_GE(sensor_presets().size(), 10U);
  for (const SensorPreset& p : sensor_presets()) {
    SCOPED_TRACE(std::string(p.name));
    EXPECT_EQ(find_preset(p.name), &p);
    EXPECT_TRUE(quantise(p.intrinsics, p.width, p.height).ok());
    // Centre near the middle, field of view between 40 and 105 degrees.
    EXPECT_NEAR(p.intrinsics.cx, p.width / 2.0, 0.05 * p.width);
    EXPECT_NEAR(p.intrinsics.cy, p.height / 2.0, 0.15 * p.height);
    const double view = 2 * std::atan(p.width / 2.0 / p.intrinsics.fx) * 180 / 3.14159265;
    EXPECT_GT(view, 40);
    EXPECT_LT(view, 105);
    EXPECT_GT(p.min_m, 0);
    EXPECT_LT(p.max_m / p.intrinsics.metres_per_unit, 65535);
    EXPECT_GT(p.rate_hz, 0);
    const bool stereo = p.noise.kind == NoiseModel::Kind::kStereo;
    EXPECT_EQ(stereo, p.baseline_m > 0);
    EXPECT_EQ(stereo, p.steps_per_pixel > 0);
    EXPECT_GT(p.noise.sigma_m(2.0), 0.0005);
    EXPECT_LT(p.noise.sigma_m(2.0), 0.02);
  }
  EXPECT_EQ(find_preset("kinect9"), nullptr);
}

}  // namespace
}  // namespace planecast
