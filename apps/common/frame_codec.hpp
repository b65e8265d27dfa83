// One stream coded in memory on the caller's thread, for eval, encode and tests: frames in, file
// form and wire form out, decoded again on request.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "apps/common/stream_setup.hpp"
#include "core/pipeline/decoder.hpp"
#include "core/pipeline/encoder.hpp"

namespace planecast {

/// Bytes of a frame and what is known about it.
struct CodedFrame {
  std::vector<std::vector<std::uint8_t>> packets;  ///< sealed slices
  FrameReport report;
  PointCounts counts;
};

/// An inline encoder of one form (slice size).
class FrameCodec {
 public:
  /// `slice_bytes`: kFileSliceBytes for the file form.
  static Result<FrameCodec> create(const StreamSetup& setup, std::size_t slice_bytes);

  /// Encodes one frame. Errors name the frame.
  Result<CodedFrame> encode(const StreamSetup& setup, const SensorFrame& frame);

  /// Encodes counts already in memory `times` times and returns the median CPU milliseconds of
  /// this thread, copying in included, after `warm_ups`.
  double time_encode(const std::vector<std::uint16_t>& depth, int times, int warm_ups);

  std::vector<std::uint8_t> key_packet(const SensorFrame& frame) const;
  const Encoder& encoder() const { return *encoder_; }

 private:
  std::unique_ptr<Encoder> encoder_;
};

/// CPU time of the calling thread [ms].
double thread_cpu_ms();

}  // namespace planecast
