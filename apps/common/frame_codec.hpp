// One stream coded in memory on the caller's thread, for eval, encode and tests: frames in, file
// form or wire form out, with the CPU time it takes.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "apps/common/stream_setup.hpp"
#include "core/pipeline/encoder.hpp"

namespace planecast {

/// A list's points in range, and what became of each.
struct CodedList {
  std::vector<Point3f> points;
  std::vector<PointFate> fates;
};
CodedList list_of(const FrameSlot& slot);

/// Bytes of a frame and what is known about it.
struct CodedFrame {
  std::vector<std::vector<std::uint8_t>> packets;  ///< sealed slices
  FrameReport report;
  PointCounts counts;
  FrameEffort effort = FrameEffort::kFull;  ///< what --budget-ms allowed
  CodedList list;                           ///< of a stream of points
  std::size_t bytes() const noexcept { return report.bytes; }
};

/// An inline encoder of one form (slice size).
class FrameCodec {
 public:
  /// `slice_bytes`: largest packet, header included; kFileSliceBytes for the file form. kUsage when
  /// the stream needs larger slices.
  static Result<FrameCodec> create(const StreamSetup& setup, std::size_t slice_bytes);

  /// Encodes one frame. Errors name the frame; those of to_depth() and to_raw_points(), and any of
  /// the stages'.
  Result<CodedFrame> encode(const StreamSetup& setup, const SensorFrame& frame);

  /// Encodes the frame `warm_ups + times` times and returns the median CPU time of this thread over
  /// the last `times` [ms]: from the array in memory (a cloud's conversion to counts and its check
  /// included) to finished bytes. The frame has been encoded before without an error.
  double time_encode(const StreamSetup& setup, const SensorFrame& frame, int times, int warm_ups);

  /// The sealed key packet as it would stand before this frame.
  std::vector<std::uint8_t> key_packet(const SensorFrame& frame) const;

  const Encoder& encoder() const { return *encoder_; }

 private:
  Result<Done> submit(const StreamSetup& setup, const SensorFrame& frame);

  std::unique_ptr<Encoder> encoder_;
  std::vector<std::uint16_t> depth_;  ///< counts of the current cloud
  std::vector<Point3f> points_;       ///< of the current raw cloud or list
  std::uint32_t out_of_range_ = 0;    ///< of the current raw cloud
};

/// CPU time of the calling thread [ms].
double thread_cpu_ms();

/// Median of some times; 0 for none.
double median_ms(std::vector<double> ms);

}  // namespace planecast
