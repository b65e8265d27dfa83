// One measurement of bench/latency: a stream at a rate through the product's own threads, every
// frame's way timed, and beside it a timer that tells how late this machine wakes anybody.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "apps/common/options.hpp"
#include "apps/common/stream_setup.hpp"

namespace planecast::bench {

/// Frames in memory, all of the stream's size; one of the two per stream.
struct Frames {
  std::vector<std::vector<std::uint16_t>> depth;
  std::vector<std::vector<Point3f>> points;
  std::size_t count() const { return depth.empty() ? points.size() : depth.size(); }
};

struct LatencyPlan {
  double rate_hz = 30;
  bool lcm = true;      ///< over LCM, publisher and subscriber included; else bytes in memory
  bool loaded = false;  ///< one core is kept busy by another thread
  std::uint32_t frames = 300;
};

/// Times of one step [ns], sorted.
struct Step {
  std::string name;
  std::vector<std::int64_t> ns;
  std::int64_t at(double percent) const;
};

struct LatencyResult {
  LatencyPlan plan;
  std::vector<Step> steps;  ///< in the order of a frame's way; the last is the whole
  Step timer;               ///< lateness of a 2 ms timer in the same run
  std::uint64_t offered = 0, readable = 0;
  std::uint64_t no_slot = 0, not_sent = 0, skipped = 0, lost = 0;  ///< where the others went
};

/// Runs the plan. kNetwork and the like where LCM cannot be used.
Result<LatencyResult> run_latency(const LatencyPlan& plan, const StreamSetup& setup,
                                  const CodecOptions& options, const Frames& frames);

}  // namespace planecast::bench
