// The real encoder and decoder on their threads under the heap guard: after start no allocation,
// no free, no mapping and nothing that blocks but the futex wait on an empty ring.
#include <gtest/gtest.h>

#include <cstdlib>
#include <ctime>
#include <mutex>

#include "tests/core/pipeline/codec_bench.hpp"
#include "tests/support/emulated.hpp"
#include "tests/support/heap_guard.hpp"

namespace planecast {
namespace {

using namespace test;

// Planted behaviour: called on each stage's thread once it is armed.
void (*planted)(const char* name) = nullptr;
void* volatile codec_sink = nullptr;
std::mutex held;

void arm_stage(const char* name) {
  HeapGuard::arm_this_thread(name);
  if (planted != nullptr) planted(name);
}

/// Runs `count` frames from a source thread through the encoder's four threads into a decoder's
/// thread, all six of them armed, and returns what the guard saw.
HeapGuardTotals run_codec(const SimStream& stream, const StreamCase& c, std::uint64_t count) {
  EncoderConfig config = encoder_config(stream, c, RunMode::kThreads, 5);
  config.runner.on_thread_start = arm_stage;
  config.runner.on_thread_stop = HeapGuard::disarm_this_thread;
  const Source source(stream, c);
  const auto encoder = make_encoder(config, false);
  const auto decoder = make_decoder(decoder_config(config.stream));
  const auto key = key_of(*encoder);
  HeapGuard::reset();
  EXPECT_TRUE(encoder->start().ok());
  std::uint64_t whole = 0, points = 0, kept = 0;
  std::thread consumer([&] {
    HeapGuard::arm_this_thread("decoder");
    EncodedFrame frame;
    while (encoder->next(frame)) {
      bool good = decoder->set_key(key) == Status::kOk && decoder->begin() == Status::kOk;
      for (std::uint32_t i = 0; i < frame.slot->report.slices; ++i)
        good = decoder->add(frame.slot->slice(i)) == Status::kOk && good;
      whole += good && decoder->finish() == Status::kOk && frame.status == Status::kOk;
      points += decoder->counts().points;
      kept += frame.slot->counts.kept;
      encoder->release(frame);
    }
    HeapGuard::disarm_this_thread();
  });
  std::uint64_t submitted = 0;
  std::thread feeder([&] {
    HeapGuard::arm_this_thread("source");
    for (std::uint64_t i = 0; i < count; ++i)
      submitted += source.submit(*encoder, i, true) == Status::kOk;
    HeapGuard::disarm_this_thread();
  });
  feeder.join();
  encoder->stop();
  consumer.join();
  EXPECT_EQ(submitted, count);
  EXPECT_EQ(whole, count);
  EXPECT_EQ(points, kept);
  EXPECT_GT(points, 0U);
  return HeapGuard::totals();
}

void expect_nothing(const HeapGuardTotals& totals) {
  EXPECT_EQ(totals.allocations, 0U) << HeapGuard::first_offender();
  EXPECT_EQ(totals.frees, 0U) << HeapGuard::first_offender();
  EXPECT_EQ(totals.maps, 0U) << HeapGuard::first_offender();
  EXPECT_EQ(totals.blocks(), 0U) << HeapGuard::first_offender();
}

class CodecNoHeap : public testing::TestWithParam<StreamCase> {
 protected:
  void SetUp() override { planted = nullptr; }
};
INSTANTIATE_TEST_SUITE_P(Kinds, CodecNoHeap, testing::ValuesIn(kStreamCases),
                         [](const auto& param) { return std::string(param.param.name); });
INSTANTIATE_TEST_SUITE_P(Lists, CodecNoHeap, testing::ValuesIn(kListCases),
                         [](const auto& param) { return std::string(param.param.name); });

TEST_P(CodecNoHeap, AThousandFramesThroughSixThreadsDoNothingForbidden) {
  PLANECAST_NEED_HEAP_GUARD();
  PLANECAST_NEED_A_MACHINE();  // twelve VGA frames of each kind follow
  // Raw clouds take ten times as long to code.
  // Surfaces of lists take longer still.
  const FrameKind kind = GetParam().kind;
  const SimStream stream = kind == FrameKind::kDepth      ? sim_stream(160, 120, 50)
                           : kind == FrameKind::kRawCloud ? sim_stream(80, 60, 50)
                                                          : sim_stream(40, 30, 50);
  expect_nothing(run_codec(stream, GetParam(), 1000));
}

TEST_P(CodecNoHeap, VgaFramesThroughSixThreadsDoNothingForbidden) {
  PLANECAST_NEED_HEAP_GUARD();
  static const SimStream vga = sim_stream(640, 480, 4), small = sim_stream(160, 120, 4);
  const SimStream& stream = GetParam().kind == FrameKind::kPoints ? small : vga;
  expect_nothing(run_codec(stream, GetParam(), 12));
}

class CodecGuard : public testing::Test {
 protected:
  void TearDown() override { planted = nullptr; }
  static HeapGuardTotals run_planted(void (*what)(const char*)) {
    static const SimStream stream = sim_stream(96, 72, 2);
    planted = what;
    return run_codec(stream, kStreamCases[0], 3);
  }
};

TEST_F(CodecGuard, CatchesAnAllocationPlantedOnEachStagesThread) {
  PLANECAST_NEED_HEAP_GUARD();
  const HeapGuardTotals totals = run_planted([](const char*) { codec_sink = std::malloc(8); });
  EXPECT_EQ(totals.allocations, 5U);  // four stages and the thread that helps to pack
  EXPECT_EQ(totals.sum(), 5U);
  EXPECT_EQ(HeapGuard::first_offender().find("malloc on thread '"), 0U);
}

TEST_F(CodecGuard, CatchesASleepPlantedOnOneStagesThreadAndNamesIt) {
  PLANECAST_NEED_HEAP_GUARD();
  const HeapGuardTotals totals = run_planted([](const char* name) {
    if (std::string_view(name) != "fit") return;
    const timespec pause{0, 1};
    nanosleep(&pause, nullptr);
  });
  EXPECT_EQ(totals.blocks(), 1U);
  EXPECT_EQ(totals.sum(), 1U);
  EXPECT_EQ(HeapGuard::first_offender().find("nanosleep on thread 'fit'"), 0U);
}

TEST_F(CodecGuard, CatchesAWaitForAMutexPlantedOnOneStagesThread) {
  PLANECAST_NEED_HEAP_GUARD();
  HeapGuard::reset();  // before the holder looks for the wait
  std::atomic<bool> taken{false};
  std::thread holder([&] {
    const std::scoped_lock lock(held);
    taken.store(true);
    while (HeapGuard::totals().blocks() == 0) std::this_thread::yield();
  });
  while (!taken.load()) std::this_thread::yield();
  const HeapGuardTotals totals = run_planted([](const char* name) {
    if (std::string_view(name) == "pack") const std::scoped_lock lock(held);
  });
  holder.join();
  EXPECT_EQ(totals.blocks(), 1U);
  EXPECT_EQ(totals.sum(), 1U);
}

}  // namespace
}  // namespace planecast
