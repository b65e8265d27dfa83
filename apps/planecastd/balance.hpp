// Where every frame went: in = out + failed + dropped, each by the named place where it happened;
// and the stages' times. Printed when the daemon ends.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "apps/common/stream_sender.hpp"
#include "core/pipeline/stage_runner.hpp"
#include "core/pipeline/watchdog.hpp"
#include "transport/publisher.hpp"

namespace planecast {

/// What was counted by whom, as they report it themselves.
struct StreamCounts {
  std::uint64_t in = 0;              ///< frames that the source had
  std::uint64_t refused = 0;         ///< of them not fit for this stream
  std::uint64_t passed_over = 0;     ///< of them never offered: newer ones came first, or the end
  std::uint64_t gated_readings = 0;  ///< of raw clouds, made holes before the pipeline
  FrameTotals pipeline;              ///< those offered
  SenderTotals sender;
  PublisherStatistics publisher;

  std::uint64_t out() const { return publisher.frames_sent; }
  std::uint64_t failed() const {
    return refused + pipeline.failed + sender.did_not_fit + publisher.frames_failed;
  }
  std::uint64_t dropped() const {
    return passed_over + pipeline.dropped + publisher.frames_dropped_oldest +
           publisher.frames_dropped_at_stop;
  }
  /// True when nothing is in flight and no frame is unaccounted for, at each joint.
  bool balanced() const;
};

/// The closing table, one line each; with a watchdog (may be null) also what it saw.
std::vector<std::string> balance_lines(const StreamCounts& counts, const StageRunner& runner,
                                       const Watchdog* watchdog = nullptr);

}  // namespace planecast
