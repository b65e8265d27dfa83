#include "apps/common/frame_codec.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <utility>

#include "apps/common/points_setup.hpp"
#include "core/wire/key_packet.hpp"
#include "core/wire/point_pack.hpp"
#include "core/wire/raw_pack.hpp"

namespace planecast {
namespace {

bool same_size(const StreamSetup& setup, const DepthImage& image) {
  const CameraModel& camera = setup.encoder.stream.camera;
  return image.width == camera.width && image.height == camera.height;
}

struct LeastSlice {
  const char* what;
  std::size_t bytes;
};

LeastSlice least_slice(FrameKind kind) {
  switch (kind) {
    case FrameKind::kRawCloud:
      return {"raw clouds", kMinRawSliceBytes};
    case FrameKind::kPoints:
      return {"points", kMinPointSliceBytes};
    case FrameKind::kDepth:
      break;
  }
  return {"depth images", kMinSliceBytes};
}

}  // namespace

double thread_cpu_ms() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) * 1e3 + static_cast<double>(now.tv_nsec) * 1e-6;
}

double median_ms(std::vector<double> ms) {
  if (ms.empty()) return 0;
  const auto middle = ms.begin() + static_cast<std::ptrdiff_t>(ms.size() / 2);
  std::nth_element(ms.begin(), middle, ms.end());
  return *middle;
}

Result<FrameCodec> FrameCodec::create(const StreamSetup& setup, std::size_t slice_bytes) {
  EncoderConfig config = setup.encoder;
  const LeastSlice least = least_slice(config.stream.kind);
  if (slice_bytes < least.bytes) {
    return Error{Status::kUsage,
                 fmt::format("--slice-bytes: leaves {} bytes for a packet, but {} of this stream "
                             "need {}; raise it by {}",
                             slice_bytes, least.what, least.bytes, least.bytes - slice_bytes)};
  }
  config.stages.slice_bytes = slice_bytes;
  config.runner.mode = RunMode::kInline;
  config.runner.slots = 1;
  auto encoder = Encoder::create(config);
  if (!encoder.ok()) return encoder.error();
  FrameCodec codec;
  codec.encoder_ = std::move(*encoder);
  if (const auto started = codec.encoder_->start(); !started.ok()) return started.error();
  return codec;
}

Result<Done> FrameCodec::submit(const StreamSetup& setup, const SensorFrame& frame) {
  Status status = Status::kOk;
  if (setup.encoder.stream.kind == FrameKind::kPoints) {
    if (const auto done = to_points(setup, frame, points_); !done.ok()) return done.error();
    status = encoder_->submit(points_, frame.number, frame.stamp_ns);
  } else if (setup.encoder.stream.kind == FrameKind::kRawCloud) {
    const auto gated = to_raw_points(setup, frame, points_);
    if (!gated.ok()) return gated.error();
    out_of_range_ = *gated;
    status = encoder_->submit(points_, frame.number, frame.stamp_ns);
  } else if (setup.cloud_input || !same_size(setup, frame.depth)) {
    if (const auto done = to_depth(setup, frame, depth_); !done.ok()) return done.error();
    status = encoder_->submit(DepthView{depth_, frame.number, frame.stamp_ns});
  } else {
    status = encoder_->submit(DepthView{frame.depth.depth, frame.number, frame.stamp_ns});
  }
  if (status != Status::kOk) {
    return Error{status, fmt::format("{}: could not be submitted to the encoder ({})", frame.name,
                                     to_string(status))};
  }
  return Done{};
}

CodedList list_of(const FrameSlot& slot) {
  CodedList out;
  for (std::uint32_t i = 0; i < slot.listed; ++i) {
    const auto fate = static_cast<PointFate>(slot.fates[i]);
    out.points.push_back(slot.points[i]);
    out.fates.push_back(fate);
  }
  return out;
}

Result<CodedFrame> FrameCodec::encode(const StreamSetup& setup, const SensorFrame& frame) {
  if (const auto done = submit(setup, frame); !done.ok()) return done.error();
  EncodedFrame encoded;
  if (!encoder_->try_next(encoded))
    return Error{Status::kStopped, frame.name + ": the encoder gave no frame back"};
  CodedFrame out;
  const Status status = encoded.status;
  out.report = encoded.slot->report;
  out.counts = encoded.slot->counts;
  out.effort = encoded.slot->effort;
  if (setup.encoder.stream.kind == FrameKind::kRawCloud) {
    out.counts.input += out_of_range_;
    out.counts.out_of_range = out_of_range_;
  }
  if (setup.encoder.stream.kind == FrameKind::kPoints) out.list = list_of(*encoded.slot);
  for (std::uint32_t i = 0; status == Status::kOk && i < out.report.slices; ++i) {
    const auto slice = encoded.slot->slice(i);
    out.packets.emplace_back(slice.begin(), slice.end());
  }
  encoder_->release(encoded);
  if (status != Status::kOk) {
    return Error{status,
                 fmt::format("{}: could not be encoded ({})", frame.name, to_string(status))};
  }
  return out;
}

double FrameCodec::time_encode(const StreamSetup& setup, const SensorFrame& frame, int times,
                               int warm_ups) {
  std::vector<double> ms;
  for (int i = 0; i < times + warm_ups; ++i) {
    const double begin = thread_cpu_ms();
    EncodedFrame encoded;
    if (!submit(setup, frame).ok() || !encoder_->try_next(encoded)) return 0;
    const double end = thread_cpu_ms();
    encoder_->release(encoded);
    if (i >= warm_ups) ms.push_back(end - begin);
  }
  return median_ms(std::move(ms));
}

std::vector<std::uint8_t> FrameCodec::key_packet(const SensorFrame& frame) const {
  std::vector<std::uint8_t> out(kPacketHeaderBytes + kMaxKeyBodyBytes);
  out.resize(encoder_->key_packet(frame.number, frame.stamp_ns, out));
  return out;
}

}  // namespace planecast
