#include "transport/statistics.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <string>
#include <thread>
#include <vector>

#include "core/base/random.hpp"
#include "transport/snapshot_box.hpp"

namespace planecast {

TEST(TransitHistogram, QuantilesAreWithinAQuarterOfTheTruth) {
  Pcg32 random(3);
  std::vector<std::int64_t> samples;
  TransitHistogram histogram;
  for (int i = 0; i < 3'000; ++i) {
    const std::int64_t ns = 1'000'000 + random.below(40'000'000);
    samples.push_back(ns);
    histogram.add(ns);
  }
  std::sort(samples.begin(), samples.end());
  for (const double share : {0.01, 0.5, 0.9, 0.99}) {
    const auto index = static_cast<std::size_t>(share * static_cast<double>(samples.size()));
    const auto truth = static_cast<double>(samples[index]);
    EXPECT_GE(static_cast<double>(histogram.quantile_ns(share)), truth * 0.99);
    EXPECT_LE(static_cast<double>(histogram.quantile_ns(share)), truth * 1.26);
  }
  EXPECT_EQ(histogram.max_ns(), samples.back());
  EXPECT_EQ(histogram.quantile_ns(1.0), samples.back());
}

TEST(TransitHistogram, TakesAnyValue) {
  TransitHistogram histogram;
  EXPECT_EQ(histogram.quantile_ns(0.5), 0);
  for (const std::int64_t ns :
       {std::int64_t{-5}, std::int64_t{0}, std::int64_t{999}, std::int64_t{3'600'000'000'000},
        std::numeric_limits<std::int64_t>::max()})
    histogram.add(ns);
  EXPECT_EQ(histogram.count(), 5U);
  EXPECT_EQ(histogram.max_ns(), std::numeric_limits<std::int64_t>::max());
  EXPECT_LE(histogram.quantile_ns(0.5), 1000);
}

TEST(TransitHistogram, EveryBucketsEdgeIsAboveItsSamples) {
  for (std::int64_t us = 1; us < 10'000'000; us += 1 + us / 50) {
    TransitHistogram histogram;
    histogram.add(us * 1000);
    histogram.add(std::int64_t{60'000'000'000});
    EXPECT_GE(histogram.quantile_ns(0.5), us * 1000);
    EXPECT_LE(histogram.quantile_ns(0.5), us * 1250 + 1000);
  }
}

TEST(Statistics, RefusedPacketsAreCountedUnderTheirCause) {
  LinkStatistics link;
  for (const Status status :
       {Status::kTruncated, Status::kTrailingBytes, Status::kBadMagic, Status::kUnsupportedVersion,
        Status::kBadCheck, Status::kFieldRange, Status::kReservedBits})
    link.count_refused(status);
  EXPECT_EQ(link.bad_length, 2U);
  EXPECT_EQ(link.bad_type, 1U);
  EXPECT_EQ(link.bad_version, 1U);
  EXPECT_EQ(link.bad_check, 1U);
  EXPECT_EQ(link.bad_packet, 2U);
}

TEST(Statistics, TextNamesStreamsAndOnlyTheFailuresThatHappened) {
  ReceiverStatistics statistics;
  statistics.stream_count = 2;
  statistics.streams[1].stream = 42;
  statistics.streams[1].slices_late = 17;
  std::string text;
  for (const std::string& line : to_lines(statistics)) text += line + "\n";
  EXPECT_NE(text.find("stream 42"), std::string::npos);
  EXPECT_NE(text.find("late 17"), std::string::npos);
  EXPECT_EQ(text.find("bad check"), std::string::npos);
  EXPECT_EQ(text.find("capture"), std::string::npos);
}

TEST(SnapshotBox, AReaderNeverSeesHalfOfAnUpdate) {
  struct Pair {
    std::uint64_t values[300];
  };
  SnapshotBox<Pair> box;
  std::atomic<bool> stop{false};
  std::thread writer([&] {
    Pair pair{};
    for (std::uint64_t i = 0; !stop.load(); ++i) {
      for (std::uint64_t& value : pair.values) ++value;
      box.store(pair);
      // A writer without any pause would starve the reader.
      if (i % 4 == 0) std::this_thread::sleep_for(std::chrono::microseconds(20));
    }
  });
  bool torn = false;
  std::uint64_t last = 0;
  for (int i = 0; i < 20'000; ++i) {
    Pair pair{};
    box.load(pair);
    for (const std::uint64_t value : pair.values) torn = torn || value != pair.values[0];
    torn = torn || pair.values[0] < last;
    last = pair.values[0];
  }
  stop.store(true);
  writer.join();
  EXPECT_FALSE(torn);
}

}  // namespace planecast
