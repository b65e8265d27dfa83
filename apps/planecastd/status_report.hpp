// One line a second on how the stream is doing: for people on standard error, and as key=value in a
// file for scripts.
#pragma once

#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>

#include "apps/common/live_line.hpp"
#include "apps/common/stream_sender.hpp"
#include "core/base/status.hpp"

namespace planecast {

/// What a line is made of: totals at one moment.
struct StreamMoment {
  std::int64_t time_ns = 0;  ///< monotonic clock
  SenderTotals sender;
  std::uint64_t dropped = 0;
  std::uint64_t failed = 0;
};

/// Means over the frames sent between two moments.
struct StreamRates {
  std::uint64_t frame = 0;  ///< number of the newest
  std::uint64_t frames = 0;
  double hz = 0;
  double surfaces = 0;      ///< a frame
  double raw_bytes = 0;     ///< a frame, 12 bytes a reading
  double packed_bytes = 0;  ///< a frame, LCM payload
  double mbit_s = 0;
  double encode_ms = 0;                   ///< median, from memory to packed bytes
  std::uint64_t dropped = 0, failed = 0;  ///< since the start
};

StreamRates rates_between(const StreamMoment& before, const StreamMoment& now,
                          std::int64_t encode_median_ns);
std::string to_live_line(const StreamRates& rates);
std::string to_status_line(const StreamRates& rates);  ///< without a newline

class StatusReport {
 public:
  /// Lines go to `talk`, and are appended to `file` unless it is "". kWriteFailed.
  static Result<StatusReport> open(std::FILE* talk, const std::string& file);

  /// Prints both lines. Main thread.
  void print(const StreamRates& rates);

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  std::unique_ptr<LiveLine> live_;
  std::unique_ptr<std::FILE, Close> file_;
};

}  // namespace planecast
