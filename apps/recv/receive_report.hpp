// The lines that planecast-recv prints: one a second for people, key=value for scripts, and the
// table at the end.
#pragma once

#include <string>
#include <vector>

#include "apps/recv/receive_totals.hpp"
#include "transport/statistics.hpp"

namespace planecast {

/// The second that runs and took `seconds` so far, all streams in one line; `more` adds slices and
/// keys.
std::string live_line(const ReceiveTotals& totals, double seconds,
                      const ReceiverStatistics& statistics, bool more);

/// The same for --status, a line a stream; `at_s` since the start. Unknown values are "nan".
std::vector<std::string> status_lines(const ReceiveTotals& totals, double at_s, double seconds,
                                      const ReceiverStatistics& statistics);

/// Totals for the end of --status, a line a stream that starts with final=1. messages and
/// wire_bytes are of the whole channel, LCM payload.
std::vector<std::string> final_lines(const ReceiveTotals& totals,
                                     const ReceiverStatistics& statistics);

/// The table at the end, for people: every frame handed on is in exactly one of its counts. `more`
/// adds every counter of transport.
std::vector<std::string> table(const ReceiveTotals& totals, const ReceiverStatistics& statistics,
                               bool more);

}  // namespace planecast
