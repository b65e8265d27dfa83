// One frame evaluated: coded in file form and in wire form, decoded, checked and timed; the figures
// that a table and --json share.
#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "apps/planecast/frame_check.hpp"
#include "apps/planecast/stream_coder.hpp"
#include "core/pipeline/decoder.hpp"

namespace planecast {

/// Everything about a frame but the nearest-point distances, which take longest and need no codec.
struct EvaluatedFrame {
  std::string name;
  PointCounts counts;
  FrameEffort effort = FrameEffort::kFull;
  FrameReport report;       ///< of the file form
  FrameVerdict verdict;     ///< of the file form
  std::string wire_broken;  ///< the wire form's broken promise, if any
  std::uint64_t wire_bytes = 0;
  std::uint32_t wire_slices = 0;
  double encode_ms = 0, decode_ms = 0;
  std::vector<Point3f> original, decoded;
  std::vector<Point3f> filtered;  ///< lists that lost points: those that were to come back
  bool list = false;              ///< of points without order: max is the Hausdorff distance
};

/// Evaluates the frames of one run. One thread.
class FrameEvaluator {
 public:
  FrameEvaluator(const CodecOptions& options, const SourceSensor& sensor);

  /// Errors of StreamCoder, and kBadSymbol and its like when the decoder refuses a slice.
  Result<EvaluatedFrame> evaluate(const SensorFrame& frame);

  const StreamSetup& setup() const { return file_.setup(); }

 private:
  Result<Done> begin();
  Result<Done> decode(const SensorFrame& frame, const CodedFrame& coded);
  Result<Done> judge_list(const SensorFrame& frame, const CodedFrame& coded, const CodedFrame& wire,
                          EvaluatedFrame& out);
  Result<Done> judge_grid(const SensorFrame& frame, const CodedFrame& coded, const CodedFrame& wire,
                          EvaluatedFrame& out);
  double time_decode(const CodedFrame& coded);

  const CodecOptions& options_;
  double rate_hz_;
  StreamCoder file_;
  std::optional<FrameCodec> wire_;
  std::unique_ptr<Decoder> decoder_;
};

/// The figures of DESIGN's eval for one frame, distances measured here. O(n log n), about a second
/// for 640 x 480; any thread.
nlohmann::ordered_json figures_of(const EvaluatedFrame& frame);

}  // namespace planecast
