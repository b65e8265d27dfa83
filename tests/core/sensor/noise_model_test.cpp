// Noise models: the texts people write and the sigma that comes out.
#include "core/sensor/noise_model.hpp"

#include <gtest/gtest.h>

#include <string>

#include "core/sensor/sensor_preset.hpp"

namespace planecast {
namespace {

TEST(NoiseModel, StereoGrowsWithTheSquareOfDepth) {
  const auto noise = parse_noise("stereo:0.003");
  ASSERT_TRUE(noise.ok());
  EXPECT_EQ(noise->s_e9, 3'000'000U);
  EXPECT_DOUBLE_EQ(noise->sigma_m(1.0), 0.003);
  EXPECT_DOUBLE_EQ(noise->sigma_m(4.0), 0.048);
}

TEST(NoiseModel, TimeOfFlightIsConstant) {
  const auto noise = parse_noise("tof:0.005");
  ASSERT_TRUE(noise.ok());
  EXPECT_DOUBLE_EQ(noise->sigma_m(1.0), 0.005);
  EXPECT_DOUBLE_EQ(noise->sigma_m(4.0), 0.005);
}

TEST(NoiseModel, TakesAPresetsName) {
  for (const SensorPreset& preset : sensor_presets()) {
    const auto noise = parse_noise(preset.name);
    ASSERT_TRUE(noise.ok());
    EXPECT_EQ(*noise, preset.noise);
  }
}

TEST(NoiseModel, TextReadsBackToTheSameModel) {
  for (const char* text : {"stereo:0.003", "tof:0.005", "stereo:1", "tof:2.25", "stereo:0.001425",
                           "tof:0.000000001", "stereo:4"}) {
    const auto noise = parse_noise(text);
    ASSERT_TRUE(noise.ok()) << text;
    EXPECT_EQ(to_string(*noise), text);
  }
  EXPECT_EQ(to_string(NoiseModel{}), "unknown");
}

TEST(NoiseModel, RefusesNonsenseAndSaysWhatIsAccepted) {
  for (const char* text :
       {"", "stereo", "stereo:", "stereo:x", "stereo:0.003m", "stereo:0", "tof:-1", "tof:nan",
        "tof:inf", "tof:5", "lidar:0.02", ":0.1", "tof:0.1:2"}) {
    const auto noise = parse_noise(text);
    ASSERT_FALSE(noise.ok()) << text;
    EXPECT_EQ(noise.error().status, Status::kUsage);
    EXPECT_NE(noise.error().message.find("stereo"), std::string::npos) << noise.error().message;
  }
}

}  // namespace
}  // namespace planecast
