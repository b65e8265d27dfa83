#include "bench/own_codec.hpp"

#include "apps/common/frame_codec.hpp"
#include "core/pipeline/decoder.hpp"

namespace planecast::bench {
namespace {

constexpr int kTimes = 5, kWarmUps = 2;

template <class T>
T value_of(Result<T> result) {
  if (!result.ok()) throw std::runtime_error(result.error().message);
  return std::move(*result);
}

void decode(Decoder& decoder, const CodedFrame& coded) {
  Status status = decoder.begin();
  for (const auto& packet : coded.packets) {
    if (status == Status::kOk) status = decoder.add(packet);
  }
  if (status == Status::kOk) status = decoder.finish();
  if (status != Status::kOk) throw std::runtime_error(std::string(to_string(status)));
}

}  // namespace

OwnResult run_own(const CodecOptions& options, const SourceSensor& sensor, const SensorFrame& frame,
                  const Tolerance& tolerance, bool timed) {
  CodecOptions own = options;
  own.tolerance = tolerance;
  own.given.insert("tolerance");
  const StreamSetup setup = value_of(setup_stream(own, sensor, frame));
  FrameCodec codec = value_of(FrameCodec::create(setup, kFileSliceBytes));
  const CodedFrame coded = value_of(codec.encode(setup, frame));
  const CameraModel& camera = setup.encoder.stream.camera;
  const DecoderConfig config{FrameLimits{camera.width, camera.height}};
  const auto decoder = value_of(Decoder::create(config));
  if (decoder->set_key(codec.key_packet(frame)) != Status::kOk)
    throw std::runtime_error("the decoder refuses the key packet");
  decode(*decoder, coded);
  OwnResult out;
  out.bytes = coded.bytes();
  out.surfaces = coded.report.surfaces;
  out.depth.assign(decoder->depth().begin(), decoder->depth().end());
  out.cloud.assign(decoder->cloud().begin(), decoder->cloud().end());
  out.memory_bytes = codec.encoder().memory_in_use() + decoder->memory_in_use();
  if (!timed) return out;
  out.encode_ms = codec.time_encode(setup, frame, kTimes, kWarmUps);
  std::vector<double> ms;
  for (int i = 0; i < kTimes + kWarmUps; ++i) {
    const double begin = thread_cpu_ms();
    decode(*decoder, coded);
    if (i >= kWarmUps) ms.push_back(thread_cpu_ms() - begin);
  }
  out.decode_ms = median_ms(std::move(ms));
  return out;
}

}  // namespace planecast::bench
