#include "core/pipeline/stage_stats.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "core/base/random.hpp"

namespace planecast {
namespace {

TEST(LatencyHistogram, BucketsTileAllTimesWithoutGap) {
  std::uint64_t next = 0;
  for (std::uint32_t bucket = 0; bucket < LatencyHistogram::kBuckets; ++bucket) {
    const std::uint64_t top = LatencyHistogram::bucket_top_ns(bucket);
    ASSERT_GE(top, next) << bucket;
    ASSERT_EQ(LatencyHistogram::bucket_of(next), bucket);
    ASSERT_EQ(LatencyHistogram::bucket_of(top), bucket);
    ASSERT_LE(static_cast<double>(top - next), static_cast<double>(next) / 16.0);
    next = top + 1;
  }
  EXPECT_EQ(next, std::uint64_t{1} << LatencyHistogram::kTopBits);
}

TEST(LatencyHistogram, EmptyOneSaysZero) {
  const auto histogram = std::make_unique<LatencyHistogram>();
  EXPECT_EQ(histogram->count(), 0U);
  EXPECT_EQ(histogram->percentile_ns(99), 0U);
  EXPECT_EQ(histogram->max_ns(), 0U);
}

TEST(LatencyHistogram, PercentilesAreWithinASixteenthAboveTheSortedTruth) {
  const auto histogram = std::make_unique<LatencyHistogram>();
  std::vector<std::uint64_t> times;
  Pcg32 random(3);
  for (int i = 0; i < 20'000; ++i) times.push_back(random.next() >> random.below(30));
  for (const std::uint64_t time : times) histogram->record(time);
  std::sort(times.begin(), times.end());
  for (const double percent : {0.1, 1.0, 50.0, 90.0, 99.0, 99.9, 100.0}) {
    const auto rank =
        static_cast<std::size_t>(std::ceil(static_cast<double>(times.size()) * percent / 100.0));
    const std::uint64_t truth = times[std::max<std::size_t>(rank, 1) - 1];
    EXPECT_GE(histogram->percentile_ns(percent), truth) << percent;
    EXPECT_LE(histogram->percentile_ns(percent), truth + truth / 16) << percent;
  }
  EXPECT_EQ(histogram->max_ns(), times.back());
  EXPECT_EQ(histogram->count(), times.size());
}

TEST(LatencyHistogram, TimesBeyondTheTopAreKeptInTheLastBucketWithTheirMaximum) {
  const auto histogram = std::make_unique<LatencyHistogram>();
  histogram->record(~std::uint64_t{0});
  EXPECT_EQ(histogram->count(), 1U);
  EXPECT_EQ(histogram->percentile_ns(50), ~std::uint64_t{0});
}

TEST(StageStats, SilenceCountsOnlyWhileThereIsWork) {
  const auto stats = std::make_unique<StageStats>();
  stats->heartbeat_ns.store(100);
  EXPECT_EQ(stats->silent_ns(false, 1000), 0);
  stats->fed_ns.store(600);
  EXPECT_EQ(stats->silent_ns(true, 1000), 400);  // since the frame came, not since the last one
  stats->fed_ns.store(50);
  EXPECT_EQ(stats->silent_ns(true, 1000), 900);
  stats->busy.store(1);
  EXPECT_EQ(stats->silent_ns(false, 1000), 900);
}

TEST(StageStats, ReportShowsWhatWasRecorded) {
  const auto stats = std::make_unique<StageStats>();
  const std::int64_t begin_ns = stats->begin(3);
  EXPECT_TRUE(stats->report("fit").busy);
  stats->end(begin_ns);
  add_one(stats->ok);
  stats->begin(2);
  const StageReport report = stats->report("fit");
  EXPECT_STREQ(report.name, "fit");
  EXPECT_EQ(report.ok, 1U);
  EXPECT_EQ(report.waiting_max, 3U);
  EXPECT_EQ(report.latency.count, 1U);
  EXPECT_GE(report.heartbeat_ns, begin_ns);
}

}  // namespace
}  // namespace planecast
