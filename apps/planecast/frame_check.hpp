// One frame's original against its reconstruction, point by point: what eval measures and what
// every tolerance promises.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "apps/common/stream_setup.hpp"
#include "core/base/status.hpp"
#include "core/pipeline/decoder.hpp"

namespace planecast {

/// The frame as it is to come back, after --range: row-major, NaN = no reading.
struct OriginalFrame {
  std::vector<Point3f> points;  ///< depth: on the camera's rays; clouds: the input's own floats
  std::vector<std::uint16_t> depth;  ///< counts; empty for raw clouds
  std::uint32_t readings = 0;
};

/// Builds the original of a frame that has been encoded under `setup`; `decoder` holds the stream's
/// key packet. Errors of to_depth, to_raw_points.
Result<OriginalFrame> original_of(const StreamSetup& setup, const SensorFrame& frame,
                                  const Decoder& decoder);

/// What the comparison found.
struct FrameVerdict {
  std::uint32_t points_out = 0;
  std::uint32_t lost = 0;      ///< readings that did not come back
  std::uint32_t invented = 0;  ///< points where the original has no reading
  bool identical = true;       ///< points and holes are the same, bit for bit
  double max_m = 0;            ///< largest distance of a point from its own reconstruction
  double utilisation = 0;      ///< largest distance over that point's bound; 1 is the limit
  std::string broken;          ///< the first promise that does not hold, in words; empty: all hold
};

/// Compares the decoder's current frame with the original. `may_drop`: readings the encoder says it
/// dropped. Lossless depth must be equal in every count, raw clouds in every bit; otherwise every
/// point must lie within its bound, no hole may be filled and only what was dropped may be missing.
/// O(pixels).
FrameVerdict check_frame(const StreamSetup& setup, const OriginalFrame& original,
                         const Decoder& decoder, std::uint32_t may_drop);

}  // namespace planecast
