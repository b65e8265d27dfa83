// What a stage tells about itself while it runs: counters, a latency histogram of fixed size and a
// heartbeat for the watchdog. One thread writes, any thread reads, nobody waits.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "core/base/arena.hpp"

namespace planecast {

/// Time of the steady clock [ns]; does not jump when the wall clock is set.
std::int64_t steady_now_ns() noexcept;

/// Adds one to a counter that only the calling thread writes: a plain store, cheaper than
/// fetch_add. Release, so that who reads it (acquire) also sees the counters that were raised
/// before it.
inline void add_one(std::atomic<std::uint64_t>& counter) noexcept {
  counter.store(counter.load(std::memory_order_relaxed) + 1, std::memory_order_release);
}

/// Percentiles of the times seen so far [ns]; a percentile is the upper edge of its bucket (at most
/// 1/16 above the true value) and never above max.
struct LatencySummary {
  std::uint64_t count = 0;
  std::uint64_t p50_ns = 0;
  std::uint64_t p90_ns = 0;
  std::uint64_t p99_ns = 0;
  std::uint64_t max_ns = 0;
};

/// Histogram of times in powers of two, each cut into 16 equal buckets (HdrHistogram's layout),
/// from 0 to 2^40 ns (18 minutes; longer ones fall into the last bucket). 4.7 kB, no allocation.
/// One thread calls record(); any thread may read meanwhile and sees a slightly older state.
class LatencyHistogram {
 public:
  static constexpr unsigned kSubBits = 4;
  static constexpr unsigned kTopBits = 40;
  static constexpr std::uint32_t kBuckets = (kTopBits - kSubBits + 1) << kSubBits;

  /// Counts one time [ns]. O(1).
  void record(std::uint64_t ns) noexcept;

  /// Smallest time that at least `percent` (0..100] of the recorded ones do not exceed, as the
  /// upper edge of its bucket [ns]; 0 when nothing was recorded. O(kBuckets).
  std::uint64_t percentile_ns(double percent) const noexcept;

  std::uint64_t count() const noexcept;
  std::uint64_t max_ns() const noexcept { return max_.load(std::memory_order_relaxed); }
  LatencySummary summary() const noexcept;

  /// Bucket of a time, and the largest time in a bucket; public for the tests of the layout.
  static std::uint32_t bucket_of(std::uint64_t ns) noexcept;
  static std::uint64_t bucket_top_ns(std::uint32_t bucket) noexcept;

 private:
  std::array<std::atomic<std::uint64_t>, kBuckets> counts_{};
  std::atomic<std::uint64_t> max_{0};
};

/// A readable copy of StageStats.
struct StageReport {
  const char* name = "";
  std::uint64_t ok = 0;           ///< frames that left the stage well
  std::uint64_t failed = 0;       ///< frames that failed in this stage
  std::uint64_t skipped = 0;      ///< frames that had failed before and flowed on untouched
  std::uint64_t late = 0;         ///< frames that took longer than the stage's deadline
  std::uint32_t waiting_max = 0;  ///< most frames ever found waiting for the stage
  std::int64_t heartbeat_ns = 0;  ///< steady clock at the last start or end of work; 0 = never
  bool busy = false;              ///< inside process() at this moment
  LatencySummary latency;         ///< time inside process()
};

/// The live counters of one stage, on cache lines of their own. Written by the stage's thread, but
/// for fed_ns.
struct alignas(kCacheLineBytes) StageStats {
  std::atomic<std::int64_t> heartbeat_ns{0};
  std::atomic<std::int64_t> fed_ns{0};  ///< when a frame last came to the idle stage; its feeder's
  std::atomic<std::uint32_t> busy{0};
  std::atomic<std::uint32_t> waiting_max{0};
  std::atomic<std::uint64_t> ok{0};
  std::atomic<std::uint64_t> failed{0};
  std::atomic<std::uint64_t> skipped{0};
  std::atomic<std::uint64_t> late{0};
  LatencyHistogram latency;

  /// Marks the start of work; returns the time to give to end().
  std::int64_t begin(std::uint32_t waiting) noexcept;

  /// Marks the end of work that began at `begin_ns`; late when it took over `deadline_ns` (0:
  /// none).
  void end(std::int64_t begin_ns, std::int64_t deadline_ns = 0) noexcept;

  /// Counts a frame that flows past.
  void skip() noexcept;

  /// Called by the thread that feeds the stage, when it gave a frame to an empty queue.
  void mark_fed() noexcept { fed_ns.store(steady_now_ns(), std::memory_order_release); }

  /// How long the stage has had work, in hand or `waiting`, without a sign of life [ns]; 0 if idle.
  std::int64_t silent_ns(bool waiting, std::int64_t now_ns) const noexcept;

  /// A copy; fields may be a frame apart while the stage runs.
  StageReport report(const char* name) const noexcept;
};

}  // namespace planecast
