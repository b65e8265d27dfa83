// The frames of some inputs and the streams that code them: one stream as long as the frames fit
// it, a new one (with a key packet of its own) from the first that does not.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/common/frame_codec.hpp"
#include "apps/common/frame_source.hpp"
#include "apps/common/stream_setup.hpp"

namespace planecast {

/// Frames of inputs with --repeat applied. One thread.
class FrameReader {
 public:
  /// Errors of open_source; kUsage for an endless --repeat. Tells the source's notes.
  static Result<FrameReader> open(const std::vector<std::string>& inputs,
                                  const CodecOptions& options);

  /// The next frame; false at the end. Errors of the source.
  Result<bool> next(SensorFrame& frame);

  /// Frames that next() will give in all.
  std::uint64_t count() const { return source_->count().value_or(0) * repeat_; }
  SourceSensor sensor() const { return source_->sensor(); }

 private:
  std::unique_ptr<FrameSource> source_;
  std::uint64_t repeat_ = 1;
  std::uint64_t round_ = 0;
};

/// Codes frames in file form, or at any slice size. One thread.
class StreamCoder {
 public:
  /// `follow_pose`: a frame whose pose differs starts a stream too, since the key packet holds it.
  StreamCoder(const CodecOptions& options, SourceSensor sensor, std::size_t slice_bytes,
              bool follow_pose)
      : options_(options),
        sensor_(std::move(sensor)),
        slice_bytes_(slice_bytes),
        follow_pose_(follow_pose) {}

  /// Encodes a frame; `fresh` says whether a stream began with it. Tells the notes of new streams.
  /// Errors of setup_stream, FrameCodec.
  Result<CodedFrame> encode(const SensorFrame& frame, bool& fresh);

  const StreamSetup& setup() const { return *setup_; }
  FrameCodec& codec() { return *codec_; }

 private:
  Result<Done> begin(const SensorFrame& frame);
  Result<Done> turn_to(const Pose& pose, bool& fresh);

  const CodecOptions& options_;
  SourceSensor sensor_;
  std::size_t slice_bytes_;
  bool follow_pose_;
  std::optional<StreamSetup> setup_;
  std::optional<FrameCodec> codec_;
};

}  // namespace planecast
