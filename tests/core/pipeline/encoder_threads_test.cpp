// The encoder's threads: the same bytes as inline, in order, and every frame accounted for when the
// source is faster than what follows it.
#include <gtest/gtest.h>

#include <atomic>

#include "tests/core/pipeline/codec_bench.hpp"

namespace planecast {
namespace {

using namespace test;

constexpr std::uint64_t kFrames = kSanitized ? 12 : 200;
constexpr std::uint64_t kListFrames =
    kSanitized ? 4 : 20;  // surfaces of lists take a hundred times as long

const SimStream& stream() {
  static const SimStream stream =
      kSanitized ? sim_stream(96, 72, kFrames) : sim_stream(160, 120, kFrames);
  return stream;
}

class EncoderThreads : public testing::TestWithParam<StreamCase> {};
INSTANTIATE_TEST_SUITE_P(Kinds, EncoderThreads, testing::ValuesIn(kStreamCases),
                         [](const auto& param) { return std::string(param.param.name); });
INSTANTIATE_TEST_SUITE_P(Lists, EncoderThreads, testing::ValuesIn(kListCases),
                         [](const auto& param) { return std::string(param.param.name); });

TEST_P(EncoderThreads, GiveTheBytesOfAnInlineRunInTheOrderOfSubmission) {
  const std::uint64_t frames = GetParam().kind == FrameKind::kPoints ? kListFrames : kFrames;
  const Source source(stream(), GetParam());
  const auto inline_encoder = make_encoder(encoder_config(stream(), GetParam(), RunMode::kInline));
  const auto threaded = make_encoder(encoder_config(stream(), GetParam(), RunMode::kThreads, 5));
  const auto expected = encode_frames(*inline_encoder, source, 0, frames);
  const auto coded = encode_frames(*threaded, source, 0, frames);
  ASSERT_EQ(expected.size(), frames);
  ASSERT_EQ(coded.size(), frames);
  for (std::size_t i = 0; i < frames; ++i) {
    ASSERT_EQ(coded[i].status, Status::kOk);
    ASSERT_EQ(coded[i].number, i);
    ASSERT_FALSE(coded[i].slices.empty());
    ASSERT_EQ(coded[i].slices, expected[i].slices) << "frame " << i;
  }
  EXPECT_EQ(key_of(*inline_encoder), key_of(*threaded));
}

// The source waits for nothing, so how many frames are dropped is up to the machine; the sums are
// not.
TEST(EncoderBalance, HoldsUnderASourceThatNeverWaits) {
  const Source source(stream(), kStreamCases[2]);
  const auto encoder =
      make_encoder(encoder_config(stream(), kStreamCases[2], RunMode::kThreads, 2));
  std::uint64_t accepted = 0, refused = 0;
  std::thread feeder([&] {
    for (std::uint64_t i = 0; i < 2 * kFrames; ++i) {
      const Status status = source.submit(*encoder, i);
      EXPECT_TRUE(status == Status::kOk || status == Status::kNoSlot);
      ++(status == Status::kOk ? accepted : refused);
    }
    encoder->stop();
  });
  std::uint64_t seen = 0, last = 0;
  EncodedFrame frame;
  while (encoder->next(frame)) {
    EXPECT_TRUE(seen == 0 || frame.slot->number > last);
    last = frame.slot->number;
    ++seen;
    encoder->release(frame);
  }
  feeder.join();
  const FrameTotals totals = encoder->runner().totals();
  EXPECT_EQ(totals.in, 2 * kFrames);
  EXPECT_EQ(totals.ok, seen);
  EXPECT_EQ(totals.dropped, refused);
  EXPECT_EQ(accepted, seen);
  EXPECT_EQ(totals.in, totals.ok + totals.failed + totals.dropped);
}

// One frame is taken for every two that come, so half of them must go: the new ones, and a frame
// taken is never older than the slots allow.
TEST(EncoderBalance, HoldsUnderASourceTwiceTooFastAndDataStayYoung) {
  constexpr std::uint32_t kSlots = 4;
  const Source source(stream(), kStreamCases[0]);
  const auto encoder =
      make_encoder(encoder_config(stream(), kStreamCases[0], RunMode::kThreads, kSlots));
  std::uint64_t offered = 0, accepted = 0, taken = 0;
  EncodedFrame frame;
  for (std::uint64_t period = 0; period < kFrames; ++period) {
    for (int i = 0; i < 2; ++i) accepted += source.submit(*encoder, offered++) == Status::kOk;
    ASSERT_TRUE(encoder->next(frame));
    // Taken once a period: each slot before it in the queue is worth one period of two frames.
    EXPECT_LE(offered - frame.slot->number, 2 * (kSlots + 1));
    encoder->release(frame);
    ++taken;
  }
  encoder->stop();
  while (encoder->next(frame)) {
    encoder->release(frame);
    ++taken;
  }
  const FrameTotals totals = encoder->runner().totals();
  EXPECT_EQ(totals.in, 2 * kFrames);
  EXPECT_EQ(totals.ok, taken);
  EXPECT_EQ(totals.failed, 0U);
  EXPECT_EQ(totals.dropped, 2 * kFrames - accepted);
  EXPECT_EQ(taken, accepted);
  EXPECT_GE(totals.dropped, kFrames - kSlots);
}

TEST(EncoderBalance, HoldsAcrossStopsOfBothKindsWhileTheSourceRuns) {
  const Source source(stream(), kStreamCases[3]);
  const auto encoder =
      make_encoder(encoder_config(stream(), kStreamCases[3], RunMode::kThreads, 3));
  std::atomic<bool> done{false};
  std::uint64_t offered = 0;
  std::thread feeder([&] {
    while (!done.load()) (void)source.submit(*encoder, offered++);
  });
  std::uint64_t taken = 0;
  for (int round = 0; round < 10; ++round) {
    EncodedFrame frame;
    for (int i = 0; i < 5 && encoder->next(frame); ++i, ++taken) encoder->release(frame);
    encoder->stop(round % 2 == 0 ? StopMode::kDrain : StopMode::kDiscard);
    for (; encoder->try_next(frame); ++taken) encoder->release(frame);
    ASSERT_TRUE(encoder->start().ok());
  }
  done.store(true);
  feeder.join();
  encoder->stop();
  taken += take_all(*encoder).size();
  const FrameTotals totals = encoder->runner().totals();
  EXPECT_EQ(totals.in, offered);
  EXPECT_EQ(totals.ok + totals.failed, taken);
  EXPECT_EQ(totals.in, totals.ok + totals.failed + totals.dropped);
}

}  // namespace
}  // namespace planecast
