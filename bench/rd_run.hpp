// One frame through every codec of the rate-distortion benchmark: the rows of its table.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bench/baselines/baseline.hpp"
#include "bench/own_codec.hpp"

namespace planecast::bench {

/// How far a decoded cloud is from the original, and what became of its points.
struct RdDistance {
  std::size_t points_out = 0;
  std::size_t merged = 0;  ///< points out that lie on exactly the spot of another one
  double d1_ab_m = 0, d1_ba_m = 0, d1_m = 0, d2_m = 0;
  double max_m = 0;  ///< of a point from its own reconstruction; Hausdorff where order is lost
};

/// A codec at a setting on a frame.
struct RdRow {
  std::string codec, setting;
  bool ours = false;
  std::optional<double> target_d1_mm;  ///< the setting was found for this d1
  std::size_t bytes = 0;
  RdDistance distance;
  double encode_ms = 0, decode_ms = 0;
};

/// The frame as everybody gets it.
struct RdFrame {
  SensorFrame frame;
  SourceSensor sensor;
  DepthImage depth;             ///< counts, 0 = no reading or out of range
  std::vector<Point3f> grid;    ///< point of each pixel [m], NaN = no reading
  baselines::PointList points;  ///< the finite ones of `grid`
};

/// Counts and points as our own lossless mode gives them back, which is checked to be what the
/// input says. Throws std::runtime_error.
RdFrame prepare_frame(const CodecOptions& options, const SourceSensor& sensor, SensorFrame frame);

/// Rows of our codec: lossless, a ladder of metres, 2sigma, and the largest bound whose d1 is at
/// most each of `targets_mm`.
std::vector<RdRow> own_rows(const CodecOptions& options, const RdFrame& frame,
                            const std::vector<double>& targets_mm);

/// Rows of every peer whose library is there and whose name has `only` in it; `skipped` names those
/// without a library.
std::vector<RdRow> peer_rows(const RdFrame& frame, const std::string& only,
                             std::vector<std::string>& skipped);

}  // namespace planecast::bench
