#include "core/pipeline/stage_stats.hpp"

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>

namespace planecast {

std::int64_t steady_now_ns() noexcept {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

// Below 2^kSubBits every value has its own bucket; above, the leading bit picks the power of two
// and the next kSubBits bits the bucket within it.
std::uint32_t LatencyHistogram::bucket_of(std::uint64_t ns) noexcept {
  const std::uint64_t capped = std::min(ns, (std::uint64_t{1} << kTopBits) - 1);
  const auto width = static_cast<unsigned>(std::bit_width(capped));
  if (width <= kSubBits) return static_cast<std::uint32_t>(capped);
  const unsigned shift = width - 1 - kSubBits;
  const auto leading =
      static_cast<std::uint32_t>(capped >> shift);  // 2^kSubBits .. 2^(kSubBits+1)-1
  return (shift << kSubBits) + leading;
}

std::uint64_t LatencyHistogram::bucket_top_ns(std::uint32_t bucket) noexcept {
  if (bucket < (2U << kSubBits)) return bucket;
  const unsigned shift = (bucket >> kSubBits) - 1;
  const std::uint64_t leading = bucket - (shift << kSubBits);
  return ((leading + 1) << shift) - 1;
}

void LatencyHistogram::record(std::uint64_t ns) noexcept {
  add_one(counts_[bucket_of(ns)]);
  if (ns > max_.load(std::memory_order_relaxed)) max_.store(ns, std::memory_order_relaxed);
}

std::uint64_t LatencyHistogram::count() const noexcept {
  std::uint64_t sum = 0;
  for (const auto& bucket : counts_) sum += bucket.load(std::memory_order_relaxed);
  return sum;
}

std::uint64_t LatencyHistogram::percentile_ns(double percent) const noexcept {
  const std::uint64_t total = count();
  if (total == 0) return 0;
  const double exact = std::ceil(static_cast<double>(total) * percent / 100.0);
  const auto rank = std::max<std::uint64_t>(1, static_cast<std::uint64_t>(exact));
  std::uint64_t seen = 0;
  for (std::uint32_t i = 0; i < kBuckets; ++i) {
    seen += counts_[i].load(std::memory_order_relaxed);
    // The last bucket also holds what is longer than its top.
    if (seen >= rank) return i + 1 == kBuckets ? max_ns() : std::min(bucket_top_ns(i), max_ns());
  }
  return max_ns();
}

LatencySummary LatencyHistogram::summary() const noexcept {
  return {count(), percentile_ns(50), percentile_ns(90), percentile_ns(99), max_ns()};
}

std::int64_t StageStats::begin(std::uint32_t waiting) noexcept {
  const std::int64_t now = steady_now_ns();
  heartbeat_ns.store(now, std::memory_order_relaxed);
  busy.store(1, std::memory_order_release);  // who sees it busy sees since when
  if (waiting > waiting_max.load(std::memory_order_relaxed))
    waiting_max.store(waiting, std::memory_order_relaxed);
  return now;
}

void StageStats::end(std::int64_t begin_ns, std::int64_t deadline_ns) noexcept {
  const std::int64_t now = steady_now_ns();
  if (deadline_ns > 0 && now - begin_ns > deadline_ns) add_one(late);
  latency.record(static_cast<std::uint64_t>(std::max<std::int64_t>(0, now - begin_ns)));
  heartbeat_ns.store(now, std::memory_order_relaxed);
  busy.store(0, std::memory_order_relaxed);
}

void StageStats::skip() noexcept {
  heartbeat_ns.store(steady_now_ns(), std::memory_order_relaxed);
  add_one(skipped);
}

std::int64_t StageStats::silent_ns(bool waiting, std::int64_t now_ns) const noexcept {
  const bool working = busy.load(std::memory_order_acquire) != 0;
  const std::int64_t heartbeat = heartbeat_ns.load(std::memory_order_acquire);
  if (working) return now_ns - heartbeat;
  if (!waiting) return 0;
  return now_ns - std::max(heartbeat, fed_ns.load(std::memory_order_acquire));
}

StageReport StageStats::report(const char* name) const noexcept {
  constexpr auto kRelaxed = std::memory_order_relaxed;
  return {name,
          ok.load(kRelaxed),
          failed.load(kRelaxed),
          skipped.load(kRelaxed),
          late.load(kRelaxed),
          waiting_max.load(kRelaxed),
          heartbeat_ns.load(kRelaxed),
          busy.load(kRelaxed) != 0,
          latency.summary()};
}

}  // namespace planecast
