// How packets become frames: order, loss, doubles, sessions, streams.
#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <vector>

#include "tests/transport/assembler_bench.hpp"

namespace planecast {
namespace {

using test::AssemblerBench;
using test::fake_packet;
using test::kMs;
using test::Numbers;
using test::slice_info;
using test::small_assembler;

}  // namespace

TEST(Assembler, CompleteFrameIsHandedOnAtOnceWithItsBytes) {
  AssemblerBench bench;
  for (const std::uint16_t index : std::array<std::uint16_t, 3>{2, 0, 3}) bench.slice(5, index);
  EXPECT_FALSE(bench.assembler->take());
  bench.slice(5, 1);
  const FrameRef frame = bench.assembler->take();
  ASSERT_TRUE(frame);
  EXPECT_TRUE(frame->complete());
  EXPECT_EQ(frame->frame, 5U);
  EXPECT_EQ(frame->stream, 1U);
  EXPECT_EQ(frame->session, 7U);
  EXPECT_EQ(frame->stamp_ns, 5 * 33'333'333LL);
  for (std::uint16_t i = 0; i < 4; ++i) {
    const auto bytes = frame->slice(i);
    EXPECT_EQ(std::vector<std::uint8_t>(bytes.begin(), bytes.end()),
              fake_packet(slice_info(7, 1, 5, i, 4)));
  }
  EXPECT_EQ(bench.stream().frames_complete, 1U);
  EXPECT_EQ(bench.stream().slices_reordered, 2U);
}

TEST(Assembler, PartialFrameIsHandedOnAtItsDeadlineAndNamesWhatIsMissing) {
  AssemblerBench bench;
  bench.slice(5, 0);
  bench.slice(5, 2);
  const std::int64_t due_ns = bench.now_ns + small_assembler().deadline_ns;
  EXPECT_EQ(bench.assembler->next_deadline_ns(), due_ns);
  bench.advance(small_assembler().deadline_ns - 1);
  EXPECT_FALSE(bench.assembler->take());
  bench.advance(1);
  const FrameRef frame = bench.assembler->take();
  ASSERT_TRUE(frame);
  EXPECT_FALSE(frame->complete());
  EXPECT_EQ(frame->slices_received, 2);
  EXPECT_FALSE(frame->slice(0).empty());
  EXPECT_TRUE(frame->slice(1).empty());
  EXPECT_FALSE(frame->slice(2).empty());
  EXPECT_TRUE(frame->slice(3).empty());
  EXPECT_EQ(bench.stream().slices_lost, 2U);
  EXPECT_EQ(bench.assembler->next_deadline_ns(), std::numeric_limits<std::int64_t>::max());
}

TEST(Assembler, FrameNPlus2ClosesFrameNAndNPlus1StaysOpen) {
  AssemblerBench bench;
  bench.slice(5, 0);
  bench.slice(6, 0);
  EXPECT_TRUE(bench.take_numbers().empty());
  bench.slice(7, 0);
  EXPECT_EQ(bench.take_numbers(), Numbers{5});
  bench.slice(6, 1);
  bench.slice(6, 2);
  bench.slice(6, 3);
  EXPECT_EQ(bench.take_numbers(), Numbers{6});
  EXPECT_EQ(bench.stream().frames_complete, 1U);
}

TEST(Assembler, FramesComeOutInOrderWhenALaterOneCompletesFirst) {
  AssemblerBench bench;
  bench.slice(5, 0);
  bench.frame(6);
  EXPECT_EQ(bench.take_numbers(), (Numbers{5, 6}));
  EXPECT_EQ(bench.stream().frames_partial, 1U);
  bench.slice(5, 1);
  EXPECT_TRUE(bench.take_numbers().empty());
  EXPECT_EQ(bench.stream().slices_late, 1U);
}

TEST(Assembler, DuplicatesAreToldFromLateSlices) {
  AssemblerBench bench;
  bench.frame(5);
  bench.slice(5, 2);  // its frame was complete: a duplicate
  bench.slice(6, 0);
  bench.slice(6, 0);
  bench.advance(40 * kMs);
  bench.slice(6, 1);  // its frame was handed on without it
  EXPECT_EQ(bench.stream().slices_duplicate, 2U);
  EXPECT_EQ(bench.stream().slices_late, 1U);
  EXPECT_EQ(bench.stream().slices_received, 8U);
}

TEST(Assembler, FirstOfTwoDifferentBytesForOneSliceWins) {
  AssemblerBench bench;
  bench.slice(5, 0, 2);
  bench.push(slice_info(7, 1, 5, 0, 2), 99);
  bench.slice(5, 1, 2);
  const FrameRef frame = bench.assembler->take();
  ASSERT_TRUE(frame);
  const auto bytes = frame->slice(0);
  EXPECT_EQ(std::vector<std::uint8_t>(bytes.begin(), bytes.end()),
            fake_packet(slice_info(7, 1, 5, 0, 2)));
}

TEST(Assembler, SliceCountThatChangesInsideAFrameIsRefused) {
  AssemblerBench bench;
  bench.slice(5, 0, 4);
  bench.slice(5, 1, 5);
  bench.slice(5, 4, 5);
  bench.slice(5, 1, 4);
  bench.slice(5, 2, 4);
  bench.slice(5, 3, 4);
  EXPECT_EQ(bench.take_numbers(), Numbers{5});
  EXPECT_EQ(bench.stream().slices_inconsistent, 2U);
  EXPECT_EQ(bench.stream().frames_complete, 1U);
}

TEST(Assembler, ImpossibleSliceNumbersNeverReachAStream) {
  AssemblerBench bench;
  bench.slice(5, 4, 4);
  bench.slice(5, 0, 0);
  bench.slice(5, 65535, 65535);
  bench.assembler->push({}, slice_info(7, 1, 5, 0, 4), bench.now_ns);
  EXPECT_EQ(bench.assembler->statistics().link.bad_packet, 4U);
  EXPECT_EQ(bench.assembler->statistics().stream_count, 0);
}

TEST(Assembler, FramesBeyondTheConfiguredSizeAreCountedNotStored) {
  AssemblerBench bench;
  bench.slice(5, 0, 17);
  PacketInfo info = slice_info(7, 1, 6, 0, 3);
  for (std::uint16_t i = 0; i < 3; ++i) {
    info.slice = i;
    const std::vector<std::uint8_t> packet = fake_packet(info, 0, 1500);
    bench.assembler->push(packet, info, bench.now_ns);
  }
  bench.advance(40 * kMs);
  EXPECT_EQ(bench.stream().slices_too_large, 2U);
  EXPECT_EQ(bench.stream().slices_delivered, 2U);
  EXPECT_EQ(bench.take_numbers(), Numbers{6});
}

TEST(Assembler, FramesOfWhichNothingArrivedAreCounted) {
  AssemblerBench bench;
  bench.frame(100);
  bench.frame(104);
  EXPECT_EQ(bench.stream().frames_lost, 3U);
  EXPECT_EQ(bench.take_numbers(), (Numbers{100, 104}));
}

TEST(Assembler, JoiningMidStreamLosesNothing) {
  AssemblerBench bench;
  bench.frame(123'456);
  EXPECT_EQ(bench.stream().frames_lost, 0U);
  EXPECT_EQ(bench.take_numbers(), Numbers{123'456});
}

TEST(Assembler, JoiningMidStreamTakesReorderedSlicesOfTheFrameBefore) {
  AssemblerBench bench;
  bench.slice(50, 0);
  for (std::uint16_t i = 0; i < 4; ++i) bench.slice(49, i);
  EXPECT_EQ(bench.take_numbers(), Numbers{49});
  EXPECT_EQ(bench.stream().slices_late, 0U);
}

TEST(Assembler, FrameNumbersWrap) {
  AssemblerBench bench;
  for (std::uint32_t number = 0xFFFFFFFDU; number != 3; ++number) bench.frame(number);
  EXPECT_EQ(bench.take_numbers(), (Numbers{0xFFFFFFFDU, 0xFFFFFFFEU, 0xFFFFFFFFU, 0, 1, 2}));
  EXPECT_EQ(bench.stream().frames_complete, 6U);
  EXPECT_EQ(bench.stream().frames_lost, 0U);
  EXPECT_EQ(bench.stream().resyncs, 0U);
}

TEST(Assembler, FrameNumbersWrapWhereTheConfigurationSays) {
  AssemblerConfig config = small_assembler();
  config.frame_bits = 24;
  AssemblerBench bench(config);
  bench.frame(0xFFFFFD);
  bench.slice(0xFFFFFE, 0);  // closed by frame 0, two numbers on
  bench.frame(0);
  bench.frame(2);  // 1 is lost
  EXPECT_EQ(bench.take_numbers(), (Numbers{0xFFFFFD, 0xFFFFFE, 0, 2}));
  EXPECT_EQ(bench.stream().frames_complete, 3U);
  EXPECT_EQ(bench.stream().frames_partial, 1U);
  EXPECT_EQ(bench.stream().frames_lost, 2U);  // 0xFFFFFF and 1
  EXPECT_EQ(bench.stream().resyncs, 0U);
}

TEST(Assembler, RefusesFrameNumbersTooShortToTellLossFromAJump) {
  AssemblerConfig config = small_assembler();
  config.frame_bits = 15;
  EXPECT_EQ(Assembler::create(config).error().status, Status::kBadConfig);
}

TEST(Assembler, HugeJumpOfTheFrameNumberStartsAnewInBothDirections) {
  AssemblerBench bench;
  bench.frame(10'000);
  bench.slice(10'001, 0);
  bench.frame(1'000'000);
  bench.frame(5);
  EXPECT_EQ(bench.take_numbers(), (Numbers{10'000, 10'001, 1'000'000, 5}));
  EXPECT_EQ(bench.stream().resyncs, 2U);
  EXPECT_EQ(bench.stream().frames_lost, 0U);
}

TEST(Assembler, RestartedSenderIsJoinedAtOnceAndItsOldPacketsAreCounted) {
  AssemblerBench bench;
  bench.frame(500);
  bench.slice(501, 0);
  bench.slice(501, 1);
  bench.frame(0, 4, 8);
  bench.slice(501, 2);  // still in flight from the old session
  EXPECT_EQ(bench.take_numbers(), (Numbers{500, 0}));
  const StreamStatistics counts = bench.stream();
  EXPECT_EQ(counts.session, 8U);
  EXPECT_EQ(counts.session_changes, 1U);
  EXPECT_EQ(counts.frames_discarded, 1U);
  EXPECT_EQ(counts.slices_discarded, 2U);
  EXPECT_EQ(counts.slices_old_session, 1U);
}

TEST(Assembler, ReplacedSenderIsHeardAgainOnceItsSuccessorIsSilent) {
  AssemblerBench bench;
  bench.frame(500);
  bench.frame(0, 4, 8);
  bench.advance(small_assembler().session_timeout_ns - 1);
  bench.frame(530);
  EXPECT_EQ(bench.stream().slices_old_session, 4U);
  bench.advance(1);
  bench.frame(531);
  EXPECT_EQ(bench.stream().session, 7U);
  EXPECT_EQ(bench.take_numbers(), (Numbers{500, 0, 531}));
}

TEST(Assembler, StreamsAreSideBySideAndAFurtherOneIsCounted) {
  AssemblerBench bench;
  for (std::uint16_t index = 0; index < 2; ++index) {
    bench.push(slice_info(7, 1, 5, index, 2));
    bench.push(slice_info(9, 40, 900, index, 2));
    bench.push(slice_info(9, 41, 900, index, 2));
  }
  const FrameRef second = bench.assembler->take(40);
  ASSERT_TRUE(second);
  EXPECT_EQ(second->frame, 900U);
  EXPECT_EQ(bench.take_numbers(), Numbers{5});
  EXPECT_FALSE(bench.assembler->take(41));
  EXPECT_EQ(bench.assembler->statistics().link.unknown_stream, 2U);
}

TEST(Assembler, TakeServesStreamsInTurn) {
  AssemblerBench bench;
  for (const std::uint32_t number : {1U, 2U}) {
    bench.push(slice_info(7, 1, number, 0, 1));
    bench.push(slice_info(7, 2, number, 0, 1));
  }
  std::vector<std::uint16_t> streams;
  while (FrameRef frame = bench.assembler->take()) streams.push_back(frame->stream);
  EXPECT_EQ(streams, (std::vector<std::uint16_t>{1, 2, 1, 2}));
}

}  // namespace planecast
