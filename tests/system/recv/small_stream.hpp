// A small stream made in memory: a wall and a step with noise, coded by the real encoder, so that
// tests of the receiver have packets in milliseconds.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "apps/common/frame_codec.hpp"
#include "apps/common/options.hpp"
#include "apps/common/parse_values.hpp"
#include "core/base/random.hpp"
#include "core/pipeline/decoder.hpp"

namespace planecast::test {

inline constexpr std::uint32_t kWidth = 160, kHeight = 120;

/// A wall at 2 m that leans, a step 0.5 m in front of it, holes, noise of some millimetres.
inline SensorFrame wall_frame(std::uint64_t number) {
  SensorFrame frame;
  frame.number = number;
  frame.name = "wall#" + std::to_string(number);
  frame.frame_id = "camera_optical";
  frame.depth.width = kWidth;
  frame.depth.height = kHeight;
  Pcg32 random(number + 1);
  for (std::uint32_t v = 0; v < kHeight; ++v) {
    for (std::uint32_t u = 0; u < kWidth; ++u) {
      const std::uint32_t z = (u > 60 && v > 50 ? 1500U : 2000U + 2 * u) + random.below(9);
      frame.depth.depth.push_back(static_cast<std::uint16_t>(random.below(100) == 0 ? 0U : z));
    }
  }
  return frame;
}

inline CodecOptions wall_options(const std::string& tolerance) {
  CodecOptions options;
  options.camera = parse_camera("150,150,79.5,59.5,0.001").value();
  options.noise = parse_noise("stereo:0.003").value();
  options.tolerance = parse_tolerance(tolerance).value();
  return options;
}

/// A list of points: a floor with noise of some millimetres, and a few points above it.
inline SensorFrame list_frame(std::uint64_t number, std::uint32_t points = 1500) {
  SensorFrame frame;
  frame.number = number;
  frame.name = "list#" + std::to_string(number);
  frame.cloud.width = points;
  frame.cloud.height = 1;
  Pcg32 random(number + 1);
  for (std::uint32_t i = 0; i < points; ++i) {
    const auto any = [&](double most) { return static_cast<float>(most * random.uniform()); };
    frame.cloud.points.push_back({any(2), any(2), i % 10 == 0 ? any(1) : any(0.004)});
  }
  return frame;
}

inline CodecOptions list_options(const std::string& tolerance) {
  CodecOptions options;
  options.noise = parse_noise("tof:0.004").value();
  options.tolerance = parse_tolerance(tolerance).value();
  options.given.insert("tolerance");
  return options;
}

/// The stream's setup and encoder.
struct SmallStream {
  StreamSetup setup;
  FrameCodec codec;

  SmallStream(const CodecOptions& options, const SensorFrame& first)
      : setup(std::move(setup_stream(options, {}, first).value())),
        codec(std::move(FrameCodec::create(setup, 1190).value())) {}

  explicit SmallStream(const std::string& tolerance, std::uint8_t number = 0,
                       std::uint32_t session = 1)
      : setup(make_setup(tolerance, number, session)),
        codec(std::move(FrameCodec::create(setup, 1190).value())) {}

  static StreamSetup make_setup(const std::string& tolerance, std::uint8_t number,
                                std::uint32_t session) {
    StreamSetup made = std::move(setup_stream(wall_options(tolerance), {}, wall_frame(0)).value());
    made.encoder.stream.stream = number;
    made.encoder.stream.session = session;
    return made;
  }
};

/// A decoder with room for the lists of a stream.
inline std::unique_ptr<Decoder> list_decoder(const SmallStream& stream) {
  FrameLimits limits{1, 1};
  limits.max_points = stream.setup.encoder.stream.points.max_points;
  return std::move(Decoder::create({limits}).value());
}

/// Decodes a coded frame with its key packet.
inline void decode(Decoder& decoder, SmallStream& stream, const SensorFrame& frame) {
  ASSERT_EQ(decoder.set_key(stream.codec.key_packet(frame)), Status::kOk);
  const auto coded = stream.codec.encode(stream.setup, frame);
  ASSERT_TRUE(coded.ok()) << coded.error().message;
  ASSERT_EQ(decoder.begin(), Status::kOk);
  for (const auto& packet : coded->packets) ASSERT_EQ(decoder.add(packet), Status::kOk);
  ASSERT_EQ(decoder.finish(), Status::kOk);
}

}  // namespace planecast::test
