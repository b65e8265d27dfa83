// The curves of bench/latency: percentile against milliseconds, as HdrHistogram draws them.
#pragma once

#include <string>
#include <vector>

#include "bench/latency_run.hpp"

namespace planecast::bench {

/// One curve a run, of the time from frame to cloud, and dashed the lateness of the machine's timer
/// in the first run. Both axes logarithmic.
std::string latency_svg(const std::vector<LatencyResult>& results);

}  // namespace planecast::bench
