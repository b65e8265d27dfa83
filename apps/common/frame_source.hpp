// Where frames come from: files in natural order, the simulator, later LCM. One small interface,
// cold path; playing at a rate is the caller's business.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/common/options.hpp"
#include "core/base/status.hpp"
#include "core/cloud/sensor_frame.hpp"

namespace planecast {

/// What a source knows of its sensor, where it knows it (the simulator does, files do not).
struct SourceSensor {
  std::optional<Intrinsics> intrinsics;
  std::optional<NoiseModel> noise;
  double rate_hz = 30;
};

class FrameSource {
 public:
  virtual ~FrameSource() = default;
  /// Fills the next frame; false at the end. Numbers and stamps (at the source's rate, from 0) go
  /// on over rewind(). One thread. An unreadable file, or one of another size than the first, is an
  /// error; the next call goes on behind it.
  virtual Result<bool> next(SensorFrame& frame) = 0;
  /// Starts again from the first frame.
  virtual void rewind() = 0;
  /// Frames in one pass; nothing when endless.
  virtual std::optional<std::uint64_t> count() const = 0;
  virtual SourceSensor sensor() const { return {}; }
  /// What the user should know, e.g. files of a folder that are no frames; one sentence each.
  virtual std::vector<std::string> notes() const { return {}; }
};

/// Opens inputs: files and folders, or one "sim:room[:FRAMES]" or
/// "sim:scan[:FRAMES]". kUsage, kNotFound, kUnreadable.
Result<std::unique_ptr<FrameSource>> open_source(const std::vector<std::string>& inputs,
                                                 const CodecOptions& options);

}  // namespace planecast
