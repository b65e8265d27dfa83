// What the tests of encoder and decoder share: streams from the simulator, every kind of stream
// that the codec knows, and runs of an encoder whose packed bytes are kept.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "core/fit/lattice_fit.hpp"
#include "core/pipeline/decoder.hpp"
#include "core/pipeline/encoder.hpp"
#include "core/sim/sim_room.hpp"
#include "core/wire/key_packet.hpp"
#include "tests/support/sanitized.hpp"

namespace planecast::test {

/// The simulator's sensor as a lossless stream; `first` decides on the lattice.
inline StreamConfig stream_of(const RoomSimulator& simulator,
                              std::span<const std::uint16_t> first) {
  StreamConfig out;
  out.session = 7;
  out.camera = simulator.camera();
  out.noise = simulator.config().noise;
  if (simulator.config().steps_per_pixel > 0) {
    if (const auto lattice = find_lattice(first)) out.lattice = *lattice;
  }
  return out;
}

/// Frames of a moving camera in the furnished room, and the stream they belong to.
struct SimStream {
  StreamConfig config;
  std::vector<std::vector<std::uint16_t>> frames;
};

inline SimStream sim_stream(std::uint32_t width, std::uint32_t height, std::uint64_t count) {
  SimConfig sim = default_sim_config();
  const double scale = width / 640.0;
  sim.width = width;
  sim.height = height;
  for (double* value : {&sim.intrinsics.fx, &sim.intrinsics.fy, &sim.intrinsics.cx})
    *value *= scale;
  sim.intrinsics.cy = height / 2.0;
  auto simulator = RoomSimulator::create(sim);
  EXPECT_TRUE(simulator.ok());
  SimStream out;
  DepthImage image;
  std::vector<std::uint16_t> ids;
  Pose pose;
  for (std::uint64_t i = 0; i < count; ++i) {
    simulator->render(i, image, ids, pose);
    out.frames.push_back(image.depth);
  }
  out.config = stream_of(*simulator, out.frames.front());
  return out;
}

/// One way to code a stream.
struct StreamCase {
  const char* name;
  FrameKind kind = FrameKind::kDepth;
  ToleranceKind tolerance = ToleranceKind::kLossless;
  double value = 0;  ///< metres or sigmas
  bool drop = false;
};

inline const StreamCase kStreamCases[] = {
    {"Lossless"},
    {"TenMillimetres", FrameKind::kDepth, ToleranceKind::kMetres, 0.010},
    {"TwoSigma", FrameKind::kDepth, ToleranceKind::kSigma, 2},
    {"SurfacesKeep", FrameKind::kDepth, ToleranceKind::kSurfaces, 3},
    {"SurfacesDrop", FrameKind::kDepth, ToleranceKind::kSurfaces, 3, true},
    {"RawCloud", FrameKind::kRawCloud},
};

/// Lists of points, of the same scenes.
inline const StreamCase kListCases[] = {
    {"PointsLossless", FrameKind::kPoints},
    {"PointsTenMillimetres", FrameKind::kPoints, ToleranceKind::kMetres, 0.010},
    {"PointsSurfacesKeep", FrameKind::kPoints, ToleranceKind::kSurfaces, 3},
    {"PointsSurfacesDrop", FrameKind::kPoints, ToleranceKind::kSurfaces, 3, true},
};

inline void PrintTo(const StreamCase& c, std::ostream* out) {
  *out << c.name;
}

/// Turns a stream of a camera into one of lists as large as its images: a grid of 1/128 of a bound
/// in metres, the bits where there is none.
inline void make_list(StreamConfig& config) {
  config.points = {};
  config.points.max_points = config.camera.pixels();
  config.points.patch_unit_nm = 390'625;
  config.noise = {NoiseModel::Kind::kTof, 4'000'000};
  config.points.step_pm = point_bound_pm(config) / 128;
  if (config.points.step_pm != 0) config.points.tolerance_steps = 126;
  config.camera = {};
  config.lattice = {};
  config.z_rule = ZRule::kProductInDouble;
  config.mirror_y = false;
  config.axes.q_q30 = PoseFixed{}.q_q30;
}

inline void set_case(const StreamCase& c, StreamConfig& config) {
  config.kind = c.kind;
  config.tolerance = c.tolerance;
  config.drop_off_surface = c.drop;
  config.tolerance_100nm = 0;
  config.sigmas_q16 = 0;
  if (c.tolerance == ToleranceKind::kMetres) {
    config.tolerance_100nm = static_cast<std::uint32_t>(std::lround(c.value * 1e7));
  } else if (c.tolerance != ToleranceKind::kLossless) {
    config.sigmas_q16 = static_cast<std::uint32_t>(std::lround(c.value * 65536));
  }
  if (c.kind == FrameKind::kRawCloud) config.lattice = {};
  if (c.kind == FrameKind::kPoints) make_list(config);
}

/// The stream in the given case.
inline EncoderConfig encoder_config(const SimStream& stream, const StreamCase& c,
                                    RunMode mode = RunMode::kInline, std::uint32_t slots = 4) {
  EncoderConfig out;
  out.stream = stream.config;
  set_case(c, out.stream);
  out.runner.mode = mode;
  out.runner.slots = slots;
  return out;
}

/// A depth image as a cloud that lies on no depth grid: raw clouds have no camera to use.
inline std::vector<Point3f> raw_points(const CameraModel& camera,
                                       const std::vector<std::uint16_t>& depth) {
  std::vector<Point3f> out(depth.size());
  for (std::uint32_t i = 0; i < depth.size(); ++i) {
    const auto u = static_cast<float>(i % camera.width), v = static_cast<float>(i / camera.width);
    const float z = static_cast<float>(depth[i]) * 0.00100013F;
    const float hole = std::nanf("");
    const auto f = static_cast<float>(camera.width);
    out[i] = depth[i] == 0 ? Point3f{hole, hole, hole}
                           : Point3f{(u / f - 0.5F) * z, (v / f - 0.4F) * z, z};
  }
  return out;
}

/// Frames in the form that the case submits.
class Source {
 public:
  Source(const SimStream& stream, const StreamCase& c) : depth_(&stream.frames) {
    if (c.kind == FrameKind::kDepth) return;
    for (const auto& frame : stream.frames)
      clouds_.push_back(raw_points(stream.config.camera, frame));
  }
  std::size_t size() const { return depth_->size(); }
  const std::vector<std::uint16_t>& depth(std::uint64_t i) const { return (*depth_)[at(i)]; }
  const std::vector<Point3f>& cloud(std::uint64_t i) const { return clouds_[at(i)]; }

  Status submit(Encoder& encoder, std::uint64_t i, bool wait = false) const noexcept {
    const auto stamp_ns = static_cast<std::int64_t>(i * 33'333'333);
    if (!clouds_.empty()) return encoder.submit(clouds_[at(i)], i, stamp_ns, wait);
    return encoder.submit(DepthView{(*depth_)[at(i)], i, stamp_ns}, wait);
  }

 private:
  std::size_t at(std::uint64_t i) const { return static_cast<std::size_t>(i % size()); }

  const std::vector<std::vector<std::uint16_t>>* depth_;
  std::vector<std::vector<Point3f>> clouds_;
};

/// A finished frame, copied out.
struct Coded {
  Status status = Status::kOk;
  std::uint64_t number = 0;
  PointCounts counts;
  std::vector<std::vector<std::uint8_t>> slices;
};

inline Coded copy_of(const EncodedFrame& frame) {
  Coded out{frame.status, frame.slot->number, frame.slot->counts, {}};
  if (frame.status != Status::kOk) return out;
  for (std::uint32_t i = 0; i < frame.slot->report.slices; ++i) {
    const auto slice = frame.slot->slice(i);
    out.slices.emplace_back(slice.begin(), slice.end());
  }
  return out;
}

/// Takes all finished frames without waiting.
inline std::vector<Coded> take_all(Encoder& encoder) {
  std::vector<Coded> out;
  EncodedFrame frame;
  while (encoder.try_next(frame)) {
    out.push_back(copy_of(frame));
    encoder.release(frame);
  }
  return out;
}

inline std::unique_ptr<Encoder> make_encoder(const EncoderConfig& config, bool start = true) {
  auto encoder = Encoder::create(config);
  if (!encoder.ok()) {
    ADD_FAILURE() << encoder.error().message;
    return nullptr;
  }
  if (start) {
    EXPECT_TRUE((*encoder)->start().ok());
  }
  return std::move(*encoder);
}

/// Encodes frames first .. first + count - 1 on a started encoder, none dropped, whatever its mode.
inline std::vector<Coded> encode_frames(Encoder& encoder, const Source& source, std::uint64_t first,
                                        std::uint64_t count) {
  std::vector<Coded> out;
  if (encoder.config().runner.mode == RunMode::kInline) {
    for (std::uint64_t i = first; i < first + count; ++i) {
      EXPECT_EQ(source.submit(encoder, i), Status::kOk);
      for (Coded& one : take_all(encoder)) out.push_back(std::move(one));
    }
    return out;
  }
  std::thread feeder([&] {
    for (std::uint64_t i = first; i < first + count; ++i)
      EXPECT_EQ(source.submit(encoder, i, true), Status::kOk);
  });
  EncodedFrame frame;
  while (out.size() < count && encoder.next(frame)) {
    out.push_back(copy_of(frame));
    encoder.release(frame);
  }
  feeder.join();
  return out;
}

inline std::vector<std::uint8_t> key_of(const Encoder& encoder, std::uint64_t frame = 0) {
  std::vector<std::uint8_t> out(kPacketHeaderBytes + kMaxKeyBodyBytes);
  out.resize(encoder.key_packet(frame, 0, out));
  return out;
}

/// The decoder that a stream needs at least.
inline DecoderConfig decoder_config(const StreamConfig& stream) {
  DecoderConfig out{{stream.camera.width, stream.camera.height}};
  out.limits.max_points = stream.points.max_points;
  return out;
}

inline std::unique_ptr<Decoder> make_decoder(const DecoderConfig& config = {}) {
  auto decoder = Decoder::create(config);
  EXPECT_TRUE(decoder.ok());
  return std::move(*decoder);
}

/// Decodes a whole frame; every slice must be accepted.
inline void decode_frame(Decoder& decoder, const Coded& frame) {
  EXPECT_EQ(decoder.begin(), Status::kOk);
  for (const auto& slice : frame.slices) EXPECT_EQ(decoder.add(slice), Status::kOk);
  EXPECT_EQ(decoder.finish(), Status::kOk);
}

/// True when both clouds hold the same bits, any NaN standing for a hole.
inline bool same_cloud(std::span<const Point3f> a, std::span<const Point3f> b) {
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (std::isnan(a[i].z) != std::isnan(b[i].z)) return false;
    if (std::isnan(a[i].z)) continue;
    if (a[i].x != b[i].x || a[i].y != b[i].y || a[i].z != b[i].z) return false;
  }
  return true;
}

}  // namespace planecast::test
