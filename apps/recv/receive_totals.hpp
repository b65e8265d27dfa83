// The reporting thread's sums over the records of frames: a total since the start and the second
// that runs, for each stream.
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "apps/recv/frame_record.hpp"
#include "core/pipeline/stage_stats.hpp"
#include "transport/statistics.hpp"

namespace planecast {

/// What came of the frames of one stream that the assembler handed on.
struct StreamTotals {
  std::uint64_t complete = 0, partial = 0, refused = 0;
  std::uint64_t no_key = 0;   ///< after the first readable frame
  std::uint64_t joining = 0;  ///< before it: the receiver came in between two key packets
  std::uint64_t slices = 0, slices_refused = 0, bytes = 0, points = 0, surfaces = 0;
  std::uint64_t sink_dropped = 0;
  std::uint64_t senders = 0;  ///< sessions seen
  std::uint32_t session = 0;
  FrameRecord last;
  LatencyHistogram latency, decode;
  // With --reference:
  std::uint64_t checked = 0, incomparable = 0, missing = 0, dropped = 0, invented = 0;
  double max_error_m = 0, max_ratio = 0;
  std::uint64_t frames() const noexcept { return complete + partial; }
};

/// The second that runs.
struct StreamSecond {
  std::uint64_t frames = 0, bytes = 0;
  std::vector<std::int64_t> latencies_ns;
  double max_ratio = 0;
  double latency_p50_ms() const;  ///< NaN without a shared clock
};

class ReceiveTotals {
 public:
  void add(const FrameRecord& record);

  /// Forgets the second; the totals stay.
  void next_second();

  const std::map<std::uint16_t, StreamTotals>& streams() const noexcept { return totals_; }
  const StreamSecond& second(std::uint16_t stream) const { return second_.at(stream); }
  std::uint64_t records() const noexcept { return records_; }

  /// A point exceeded its bound, is missing or was invented.
  bool bound_exceeded() const;
  /// A frame was lost, incomplete, unreadable or not comparable, or none came at all.
  bool frame_missing(const ReceiverStatistics& statistics) const;

 private:
  std::map<std::uint16_t, StreamTotals> totals_;
  std::map<std::uint16_t, StreamSecond> second_;
  std::uint64_t records_ = 0;
};

/// The assembler's counters of one stream; zeros when it has none.
StreamStatistics stream_statistics(const ReceiverStatistics& statistics, std::uint16_t stream);

}  // namespace planecast
