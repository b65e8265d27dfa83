// Counts of times in buckets a quarter of an octave wide, 1 us to 17 s: quantiles within 25 %
// from fixed memory and one increment a sample.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace planecast {

class TransitHistogram {
 public:
  /// Adds one time [ns]; a negative one counts as zero. O(1), allocates nothing.
  void add(std::int64_t ns) noexcept {
    const std::int64_t clamped = std::max<std::int64_t>(ns, 0);
    ++buckets_[bucket_of(static_cast<std::uint64_t>(clamped) / 1000)];
    ++count_;
    max_ns_ = std::max(max_ns_, clamped);
  }

  std::uint64_t count() const noexcept { return count_; }
  std::int64_t max_ns() const noexcept { return max_ns_; }

  /// Upper edge [ns] of the bucket that holds the given share (0 .. 1) of the samples, at most
  /// max_ns(); 0 without samples.
  std::int64_t quantile_ns(double share) const noexcept {
    const double wanted = share * static_cast<double>(count_);
    std::uint64_t seen = 0;
    for (std::size_t i = 0; i < kBuckets; ++i) {
      seen += buckets_[i];
      if (seen > 0 && static_cast<double>(seen) >= wanted)
        return std::min(max_ns_, upper_edge_us(i) * 1000);
    }
    return max_ns_;
  }

 private:
  static constexpr std::size_t kSubBits = 2;
  static constexpr std::size_t kBuckets = 25U << kSubBits;

  // Exact below 4 us; above, the leading bit and the two bits after it.
  static std::size_t bucket_of(std::uint64_t us) noexcept {
    if (us < (1U << kSubBits)) return static_cast<std::size_t>(us);
    const auto octave = static_cast<std::size_t>(std::bit_width(us)) - 1 - kSubBits;
    const std::size_t sub = static_cast<std::size_t>(us >> octave) & ((1U << kSubBits) - 1);
    return std::min(((octave + 1) << kSubBits) + sub, kBuckets - 1);
  }

  static std::int64_t upper_edge_us(std::size_t bucket) noexcept {
    const std::size_t octave = bucket >> kSubBits;
    const auto sub = static_cast<std::int64_t>(bucket & ((1U << kSubBits) - 1));
    if (octave == 0) return sub + 1;
    return (sub + 1 + (1 << kSubBits)) << (octave - 1);
  }

  std::array<std::uint32_t, kBuckets> buckets_{};
  std::uint64_t count_ = 0;
  std::int64_t max_ns_ = 0;
};

}  // namespace planecast
