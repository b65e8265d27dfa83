// Our own codec as the benchmarks run it: one frame at one tolerance, in file form, on one thread.
#pragma once

#include <string>
#include <vector>

#include "apps/common/frame_source.hpp"
#include "apps/common/options.hpp"
#include "bench/baselines/baseline.hpp"

namespace planecast::bench {

/// A frame coded and decoded again.
struct OwnResult {
  std::size_t bytes = 0;
  std::vector<std::uint16_t> depth;  ///< decoded counts, row-major; empty for raw clouds
  std::vector<Point3f> cloud;        ///< decoded, row-major, NaN = no reading
  std::uint32_t surfaces = 0;
  std::size_t memory_bytes = 0;         ///< of encoder and decoder
  double encode_ms = 0, decode_ms = 0;  ///< 0 unless timed
};

/// Codes `frame` as `options` say with the tolerance given ("10mm"); `timed`: medians of 5 runs
/// after 2 warm-ups. Throws std::runtime_error with the codec's message.
OwnResult run_own(const CodecOptions& options, const SourceSensor& sensor, const SensorFrame& frame,
                  const Tolerance& tolerance, bool timed);

}  // namespace planecast::bench
