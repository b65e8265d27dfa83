#include "apps/planecast/stream_coder.hpp"

#include <utility>

#include "apps/planecast/commands.hpp"

namespace planecast {

Result<FrameReader> FrameReader::open(const std::vector<std::string>& inputs,
                                      const CodecOptions& options) {
  if (options.repeat == 0) {
    return Error{Status::kUsage,
                 "--repeat 0: plays without end, which only planecastd can; give a number"};
  }
  auto source = open_source(inputs, options);
  if (!source.ok()) return source.error();
  tell((*source)->notes());
  FrameReader reader;
  reader.source_ = std::move(*source);
  reader.repeat_ = options.repeat;
  return reader;
}

Result<bool> FrameReader::next(SensorFrame& frame) {
  auto got = source_->next(frame);
  if (!got.ok() || *got || round_ + 1 >= repeat_) return got;
  ++round_;
  source_->rewind();
  return source_->next(frame);
}

Result<Done> StreamCoder::begin(const SensorFrame& frame) {
  auto setup = setup_stream(options_, sensor_, frame);
  if (!setup.ok()) return setup.error();
  auto codec = FrameCodec::create(*setup, slice_bytes_);
  if (!codec.ok()) return codec.error();
  if (!setup_ || setup_->notes != setup->notes) tell(setup->notes);
  setup_ = std::move(*setup);
  codec_ = std::move(*codec);
  return Done{};
}

Result<Done> StreamCoder::turn_to(const Pose& pose, bool& fresh) {
  PoseFixed fixed;
  PoseFixed& current = setup_->encoder.stream.pose;
  if (to_fixed(pose, fixed) != Status::kOk || fixed == current) return Done{};
  current = fixed;
  auto codec = FrameCodec::create(*setup_, slice_bytes_);
  if (!codec.ok()) return codec.error();
  codec_ = std::move(*codec);
  fresh = true;
  return Done{};
}

Result<CodedFrame> StreamCoder::encode(const SensorFrame& frame, bool& fresh) {
  fresh = false;
  if (setup_) {
    if (follow_pose_) {
      if (const auto done = turn_to(frame.pose, fresh); !done.ok()) return done.error();
    }
    auto coded = codec_->encode(*setup_, frame);
    // A cloud of another camera or grid: it gets a stream of its own.
    if (coded.ok() || coded.error().status != Status::kBoundExceeded) return coded;
    tell(
        {frame.name + ": does not follow the camera of the frames before it; a new stream begins"});
  }
  fresh = true;
  if (const auto done = begin(frame); !done.ok()) return done.error();
  return codec_->encode(*setup_, frame);
}

}  // namespace planecast
