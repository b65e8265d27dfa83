// A robot's program against the installed library: one stream of depth frames is packed and
// unpacked in memory that the program gives, and every point is checked. Exits 0 when all holds.
//
// How it is set up: find_package(planecast), link planecast::planecast (or single rooms, such as
// planecast::pipeline). Headers keep the paths they have in the source tree, under the installed
// include/planecast, which the CMake targets put on the include path: there is no second set of
// names to learn, and no header that includes everything.
//   core/pipeline/encoder.hpp   Encoder: submit() on the source's thread, next() on the consumer's
//   core/pipeline/decoder.hpp   Decoder: set_key(), then begin(), add() for each slice, finish()
//   transport/publisher.hpp     slices onto LCM;  transport/subscriber.hpp  and back
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <vector>

#include "core/pipeline/decoder.hpp"
#include "core/pipeline/encoder.hpp"
#include "core/sensor/sensor_preset.hpp"
#include "core/wire/key_packet.hpp"
#include "transport/lcm_url.hpp"

namespace {

constexpr double kToleranceM = 0.010;

/// A block for the library's use, on the boundary it asks for. The program owns it.
class Memory {
 public:
  explicit Memory(std::size_t bytes)
      : bytes_(bytes), block_(std::aligned_alloc(64, (bytes + 63) / 64 * 64)) {}
  ~Memory() { std::free(block_); }
  Memory(const Memory&) = delete;
  Memory& operator=(const Memory&) = delete;
  std::span<std::byte> span() const { return {static_cast<std::byte*>(block_), bytes_}; }

 private:
  std::size_t bytes_;
  void* block_;
};

/// A Kinect at 10 mm, one thread a stage, at most four frames on their way.
planecast::EncoderConfig settings(const planecast::SensorPreset& sensor) {
  planecast::EncoderConfig config;
  config.stream.camera = *quantise(sensor.intrinsics, sensor.width, sensor.height);
  config.stream.noise = sensor.noise;
  config.stream.tolerance = planecast::ToleranceKind::kMetres;
  config.stream.tolerance_100nm = static_cast<std::uint32_t>(kToleranceM * 1e7);
  config.runner.slots = 4;
  config.runner.mode = planecast::RunMode::kThreads;
  return config;
}

/// A wall 2 m away that leans to the right, with a hole in its middle [mm].
std::vector<std::uint16_t> wall(const planecast::CameraModel& camera) {
  std::vector<std::uint16_t> depth(camera.pixels());
  for (std::uint32_t i = 0; i < depth.size(); ++i) {
    const std::uint32_t u = i % camera.width, v = i / camera.width;
    const bool hole = u > 300 && u < 340 && v > 200 && v < 280;
    depth[i] = hole ? std::uint16_t{0}
                    : static_cast<std::uint16_t>(1.0 / (0.0005 - 1e-7 * u) + (u * v % 5));
  }
  return depth;
}

/// Decodes a packed frame; false when any packet is refused.
bool decode(planecast::Decoder& decoder, const planecast::FrameSlot& frame) {
  bool good = decoder.begin() == planecast::Status::kOk;
  for (std::uint32_t i = 0; i < frame.report.slices; ++i)
    good = decoder.add(frame.slice(i)) == planecast::Status::kOk && good;
  return decoder.finish() == planecast::Status::kOk && good;
}

/// Largest depth error [m]; infinite when a hole was filled or a reading lost.
double worst_error_m(const std::vector<std::uint16_t>& sent,
                     std::span<const planecast::Point3f> got) {
  double worst = sent.size() == got.size() ? 0 : INFINITY;
  for (std::size_t i = 0; i < got.size(); ++i) {
    if ((sent[i] == 0) != std::isnan(got[i].z)) return INFINITY;
    if (sent[i] != 0) worst = std::fmax(worst, std::fabs(got[i].z - sent[i] * 0.001));
  }
  return worst;
}

int fail(const planecast::Error& error) {
  std::printf("failed: %s (%s)\n", error.message.c_str(),
              planecast::to_string(error.status).data());
  return 1;
}

}  // namespace

int main() {
  const auto url = planecast::parse_lcm_url("udpm://239.1.2.3:7000");
  if (!url.ok()) return fail(url.error());

  const planecast::EncoderConfig config = settings(*planecast::find_preset("kinect1"));
  const auto encoder_bytes = planecast::Encoder::memory_bytes(config);
  if (!encoder_bytes.ok()) return fail(encoder_bytes.error());
  const Memory encoder_memory(*encoder_bytes);
  auto encoder = planecast::Encoder::create(config, encoder_memory.span());
  if (!encoder.ok()) return fail(encoder.error());

  const planecast::DecoderConfig decoder_config{{640, 480}};
  const Memory decoder_memory(planecast::Decoder::memory_bytes(decoder_config));
  auto decoder = planecast::Decoder::create(decoder_config, decoder_memory.span());
  if (!decoder.ok()) return fail(decoder.error());

  std::vector<std::uint8_t> key(planecast::kPacketHeaderBytes + planecast::kMaxKeyBodyBytes);
  key.resize((*encoder)->key_packet(0, 0, key));
  if ((*decoder)->set_key(key) != planecast::Status::kOk) return 1;

  if (const auto started = (*encoder)->start(); !started.ok()) return fail(started.error());
  const std::vector<std::uint16_t> depth = wall(config.stream.camera);
  for (std::uint64_t i = 0; i < 3; ++i) {
    if ((*encoder)->submit({depth, i, 0}) != planecast::Status::kOk) return 1;
  }
  (*encoder)->stop();

  int frames = 0;
  planecast::EncodedFrame frame;
  for (; (*encoder)->next(frame); ++frames) {
    const double worst =
        decode(**decoder, *frame.slot) ? worst_error_m(depth, (*decoder)->cloud()) : INFINITY;
    std::printf("frame %d: %u points in %u slices, %zu bytes, worst %.1f mm\n", frames,
                (*decoder)->counts().points, frame.slot->report.slices, frame.slot->report.bytes,
                worst * 1e3);
    (*encoder)->release(frame);
    if (!(worst <= kToleranceM)) return 1;
  }
  return frames == 3 ? 0 : 1;
}
