#include "apps/common/frame_codec.hpp"

#include <algorithm>
#include <ctime>

#include "core/wire/key_packet.hpp"

namespace planecast {

double thread_cpu_ms() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) * 1e3 + static_cast<double>(now.tv_nsec) * 1e-6;
}

Result<FrameCodec> FrameCodec::create(const StreamSetup& setup, std::size_t slice_bytes) {
  EncoderConfig config = setup.encoder;
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

Result<CodedFrame> FrameCodec::encode(const StreamSetup& setup, const SensorFrame& frame) {
  Status status = Status::kOk;
  if (setup.encoder.stream.kind == FrameKind::kRawCloud) {
    status = encoder_->submit(frame.cloud.points, frame.number, frame.stamp_ns);
  } else {
    std::vector<std::uint16_t> depth;
    if (const auto done = to_depth(setup, frame, depth); !done.ok()) return done.error();
    status = encoder_->submit(DepthView{depth, frame.number, frame.stamp_ns});
  }
  EncodedFrame encoded;
  if (status != Status::kOk || !encoder_->try_next(encoded)) {
    return Error{status,
                 frame.name + ": could not be submitted: " + std::string(to_string(status))};
  }
  CodedFrame out;
  status = encoded.status;
  out.report = encoded.slot->report;
  out.counts = encoded.slot->counts;
  for (std::uint32_t i = 0; i < out.report.slices; ++i) {
    const auto slice = encoded.slot->slice(i);
    out.packets.emplace_back(slice.begin(), slice.end());
  }
  encoder_->release(encoded);
  if (status != Status::kOk)
    return Error{status, frame.name + ": could not be encoded: " + std::string(to_string(status))};
  return out;
}

double FrameCodec::time_encode(const std::vector<std::uint16_t>& depth, int times, int warm_ups) {
  std::vector<double> ms;
  for (int i = 0; i < times + warm_ups; ++i) {
    const double begin = thread_cpu_ms();
    EncodedFrame encoded;
    if (encoder_->submit(DepthView{depth, 0, encoder_->config().stream.epoch_ns}) != Status::kOk ||
        !encoder_->try_next(encoded))
      return 0;
    const double end = thread_cpu_ms();
    encoder_->release(encoded);
    if (i >= warm_ups) ms.push_back(end - begin);
  }
  std::nth_element(ms.begin(), ms.begin() + static_cast<std::ptrdiff_t>(ms.size() / 2), ms.end());
  return ms[ms.size() / 2];
}

std::vector<std::uint8_t> FrameCodec::key_packet(const SensorFrame& frame) const {
  std::vector<std::uint8_t> out(kPacketHeaderBytes + kMaxKeyBodyBytes);
  out.resize(encoder_->key_packet(frame.number, frame.stamp_ns, out));
  return out;
}

}  // namespace planecast
