#include "apps/planecastd/balance.hpp"

#include <gtest/gtest.h>

#include "apps/planecastd/status_report.hpp"

namespace planecast {
namespace {

/// 100 frames: 2 refused, 3 passed over, 20 found no slot, 5 failed to encode, 4 fit no buffer,
/// 6 were dropped by the publisher, 1 at the stop, 2 refused by the kernel, 57 went out.
StreamCounts some_counts() {
  StreamCounts counts;
  counts.in = 100;
  counts.refused = 2;
  counts.passed_over = 3;
  counts.pipeline = {.in = 95, .ok = 70, .failed = 5, .dropped = 20};
  counts.sender.sent = 66;
  counts.sender.failed = 5;
  counts.sender.did_not_fit = 4;
  counts.publisher.frames_published = 66;
  counts.publisher.frames_sent = 57;
  counts.publisher.frames_failed = 2;
  counts.publisher.frames_dropped_oldest = 6;
  counts.publisher.frames_dropped_at_stop = 1;
  return counts;
}

}  // namespace

TEST(Balance, HoldsWhenEveryFrameIsInOnePlace) {
  const StreamCounts counts = some_counts();
  EXPECT_TRUE(counts.balanced());
  EXPECT_EQ(counts.out(), 57U);
  EXPECT_EQ(counts.failed(), 13U);
  EXPECT_EQ(counts.dropped(), 30U);
}

TEST(Balance, NoticesAFrameMissingAtAnyJoint) {
  std::uint64_t StreamCounts::*const own[] = {&StreamCounts::in, &StreamCounts::refused,
                                              &StreamCounts::passed_over};
  for (const auto member : own) {
    StreamCounts counts = some_counts();
    ++(counts.*member);
    EXPECT_FALSE(counts.balanced());
  }
  StreamCounts counts = some_counts();
  --counts.pipeline.ok;
  EXPECT_FALSE(counts.balanced());
  counts = some_counts();
  ++counts.sender.sent;
  EXPECT_FALSE(counts.balanced());
  counts = some_counts();
  ++counts.sender.failed;
  EXPECT_FALSE(counts.balanced());
  counts = some_counts();
  --counts.publisher.frames_sent;
  EXPECT_FALSE(counts.balanced());
}

TEST(StatusReport, RatesAreMeansOverTheFramesBetween) {
  StreamMoment before;
  before.time_ns = 1'000'000'000;
  before.sender.sent = 10;
  before.sender.readings = 1'000;
  before.sender.surfaces = 100;
  before.sender.bytes = 5'000;
  StreamMoment now = before;
  now.time_ns = 3'000'000'000;
  now.sender.sent = 50;
  now.sender.readings = 5'000;
  now.sender.surfaces = 500;
  now.sender.bytes = 255'000;
  now.sender.last_frame = 52;
  now.dropped = 3;
  now.failed = 1;
  const StreamRates rates = rates_between(before, now, 7'500'000);
  EXPECT_EQ(to_status_line(rates),
            "frame=52 hz=20.00 surfaces=10.0 raw_bytes=1200 packed_bytes=6250 mbit_s=1.000 "
            "encode_ms=7.500 dropped=3 failed=1");
}

TEST(StatusReport, SecondWithoutAFrameIsAllZeroes) {
  StreamMoment before;
  StreamMoment now;
  now.time_ns = 1'000'000'000;
  const StreamRates rates = rates_between(before, now, 0);
  EXPECT_EQ(rates.hz, 0);
  EXPECT_EQ(rates.packed_bytes, 0);
}

}  // namespace planecast
