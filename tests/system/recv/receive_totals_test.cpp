// Records of frames into sums, lines and the verdict.
#include "apps/recv/receive_totals.hpp"

#include <gtest/gtest.h>

#include "apps/recv/receive_report.hpp"

namespace planecast {
namespace {

FrameRecord record_of(FrameEnd end, std::uint32_t frame, std::uint32_t session = 7) {
  FrameRecord record;
  record.end = end;
  record.frame = frame;
  record.session = session;
  record.points = 100;
  record.latency_ns = 5'000'000;
  return record;
}

ReceiverStatistics statistics_of(std::uint64_t lost) {
  ReceiverStatistics statistics;
  statistics.stream_count = 1;
  statistics.streams[0].frames_lost = lost;
  return statistics;
}

}  // namespace

TEST(ReceiveTotals, EveryFrameIsInExactlyOneCount) {
  ReceiveTotals totals;
  totals.add(record_of(FrameEnd::kNoKey, 1));  // came in between two key packets
  totals.add(record_of(FrameEnd::kComplete, 2));
  totals.add(record_of(FrameEnd::kPartial, 3));
  totals.add(record_of(FrameEnd::kNoKey, 4));
  totals.add(record_of(FrameEnd::kRefused, 5));
  const StreamTotals& t = totals.streams().at(0);
  EXPECT_EQ(t.joining, 1U);
  EXPECT_EQ(t.complete, 1U);
  EXPECT_EQ(t.partial, 1U);
  EXPECT_EQ(t.no_key, 1U);
  EXPECT_EQ(t.refused, 1U);
  EXPECT_EQ(totals.records(), 5U);
  EXPECT_EQ(t.points, 200U);
}

TEST(ReceiveTotals, OnlyFramesBeforeTheFirstReadableOneAreForgiven) {
  ReceiveTotals totals;
  EXPECT_TRUE(totals.frame_missing(statistics_of(0))) << "nothing came";
  totals.add(record_of(FrameEnd::kNoKey, 1));
  totals.add(record_of(FrameEnd::kComplete, 2));
  EXPECT_FALSE(totals.frame_missing(statistics_of(0)));
  EXPECT_TRUE(totals.frame_missing(statistics_of(1)));
  totals.add(record_of(FrameEnd::kNoKey, 3));
  EXPECT_TRUE(totals.frame_missing(statistics_of(0)));
}

TEST(ReceiveTotals, APointOverItsBoundIsNeverForgotten) {
  ReceiveTotals totals;
  FrameRecord record = record_of(FrameEnd::kComplete, 1);
  record.checked = record.comparable = true;
  record.max_ratio = 1.0;
  totals.add(record);
  EXPECT_FALSE(totals.bound_exceeded());
  record.max_ratio = 1.001;
  totals.add(record);
  record.max_ratio = 0.5;
  totals.add(record);
  totals.next_second();
  EXPECT_TRUE(totals.bound_exceeded());
}

TEST(ReceiveTotals, SecondsStartAnewAndTotalsStay) {
  ReceiveTotals totals;
  for (std::uint32_t i = 0; i < 30; ++i) totals.add(record_of(FrameEnd::kComplete, i));
  EXPECT_NE(status_lines(totals, 1.0, 1.0, statistics_of(0))
                .at(0)
                .find("frames=30 hz=30.00 surfaces=0 points=100 bytes=0 latency_p50_ms=5.000"),
            std::string::npos);
  totals.next_second();
  const std::string idle = status_lines(totals, 2.0, 1.0, statistics_of(0)).at(0);
  EXPECT_NE(idle.find("frames=30 hz=0.00"), std::string::npos) << idle;
  EXPECT_NE(idle.find("latency_p50_ms=nan"), std::string::npos) << idle;
  EXPECT_NE(final_lines(totals, statistics_of(2)).at(0).find("complete=30 partial=0 lost=2"),
            std::string::npos);
}

TEST(ReceiveTotals, AnotherSessionIsAnotherSender) {
  ReceiveTotals totals;
  totals.add(record_of(FrameEnd::kComplete, 1, 7));
  totals.add(record_of(FrameEnd::kComplete, 2, 7));
  totals.add(record_of(FrameEnd::kComplete, 0, 8));
  EXPECT_EQ(totals.streams().at(0).senders, 2U);
}

}  // namespace planecast
