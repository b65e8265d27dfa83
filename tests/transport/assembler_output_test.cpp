// What the assembler hands on: key packets, newest frames, memory, threads, figures.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <thread>
#include <vector>

#include "tests/transport/assembler_bench.hpp"

namespace planecast {
namespace {

using test::AssemblerBench;
using test::fake_packet;
using test::key_info;
using test::kMs;
using test::Numbers;
using test::slice_info;
using test::small_assembler;

}  // namespace

TEST(AssemblerOutput, EachFrameCarriesTheNewestKeyNotNewerThanItself) {
  AssemblerBench bench;
  const auto key_of = [](std::uint32_t frame) { return fake_packet(key_info(7, 1, frame)); };
  const auto bytes = [](std::span<const std::uint8_t> span) {
    return std::vector<std::uint8_t>(span.begin(), span.end());
  };
  bench.frame(9);
  bench.push(key_info(7, 1, 10));
  bench.slice(10, 0);
  bench.slice(10, 1);
  bench.push(key_info(7, 1, 11));  // frame 10 is still open
  bench.slice(10, 2);
  bench.slice(10, 3);
  bench.frame(11);
  FrameRef frame = bench.assembler->take();
  ASSERT_TRUE(frame);
  EXPECT_TRUE(frame->key().empty());
  EXPECT_EQ(frame->key_serial, 0U);
  frame = bench.assembler->take();
  ASSERT_TRUE(frame);
  EXPECT_EQ(bytes(frame->key()), key_of(10));
  const std::uint32_t first_serial = frame->key_serial;
  frame = bench.assembler->take();
  ASSERT_TRUE(frame);
  EXPECT_EQ(bytes(frame->key()), key_of(11));
  EXPECT_NE(frame->key_serial, first_serial);
}

TEST(AssemblerOutput, OutdatedRepeatedAndOversizedKeysAreIgnored) {
  AssemblerBench bench;
  bench.push(key_info(7, 1, 10));
  bench.push(key_info(7, 1, 10));
  bench.push(key_info(7, 1, 9));
  const PacketInfo large = key_info(7, 1, 12);
  bench.assembler->push(fake_packet(large, 0, 300), large, bench.now_ns);
  EXPECT_EQ(bench.stream().keys_received, 4U);
  EXPECT_EQ(bench.stream().keys_ignored, 3U);
}

TEST(AssemblerOutput, AKeyOfTheOldSessionIsNotGivenToFramesOfTheNew) {
  AssemblerBench bench;
  bench.push(key_info(7, 1, 10));
  bench.frame(10);
  bench.frame(11, 4, 8);
  FrameRef frame = bench.assembler->take();
  EXPECT_FALSE(frame->key().empty());
  frame = bench.assembler->take();
  ASSERT_TRUE(frame);
  EXPECT_TRUE(frame->key().empty());
}

TEST(AssemblerOutput, AKeyStartsItsFrame) {
  AssemblerBench bench;
  bench.slice(5, 0);
  bench.push(key_info(7, 1, 7));
  EXPECT_EQ(bench.take_numbers(), Numbers{5});
}

TEST(AssemblerOutput, NewestFrameReplacesTheOneNotTaken) {
  AssemblerConfig config = small_assembler();
  config.output_frames = 1;
  AssemblerBench bench(config);
  for (std::uint32_t number = 0; number < 10; ++number) bench.frame(number);
  EXPECT_EQ(bench.take_numbers(), Numbers{9});
  EXPECT_EQ(bench.stream().frames_skipped, 9U);
  EXPECT_EQ(bench.stream().frames_taken, 1U);
}

TEST(AssemblerOutput, AFrameInUseIsNeverOverwritten) {
  AssemblerConfig config = small_assembler();
  config.output_frames = 1;
  config.held_frames = 1;
  AssemblerBench bench(config);
  bench.frame(0);
  const FrameRef held = bench.assembler->take();
  for (std::uint32_t number = 1; number < 50; ++number) bench.frame(number);
  EXPECT_EQ(held->frame, 0U);
  const auto bytes = held->slice(3);
  EXPECT_EQ(std::vector<std::uint8_t>(bytes.begin(), bytes.end()),
            fake_packet(slice_info(7, 1, 0, 3, 4)));
  EXPECT_EQ(bench.take_numbers(), Numbers{49});
  EXPECT_EQ(bench.stream().slices_no_slot, 0U);
}

TEST(AssemblerOutput, ConsumerThatHoldsTooMuchLosesFramesCounted) {
  AssemblerConfig config = small_assembler();
  config.frames_in_assembly = 1;
  config.output_frames = 1;
  config.held_frames = 1;
  AssemblerBench bench(config);
  std::vector<FrameRef> hoard;
  for (std::uint32_t number = 0; number < 5; ++number) {
    bench.frame(number, 1);
    if (FrameRef frame = bench.assembler->take()) hoard.push_back(std::move(frame));
  }
  EXPECT_EQ(hoard.size(), 3U);
  EXPECT_EQ(bench.stream().slices_no_slot, 2U);
  hoard.clear();
  bench.frame(5, 1);
  EXPECT_EQ(bench.take_numbers(), Numbers{5});
}

TEST(AssemblerOutput, MemoryIsExactlyWhatWasTold) {
  const AssemblerConfig config = small_assembler();
  Result<Arena> arena = Arena::map(Assembler::memory_bytes(config));
  ASSERT_TRUE(arena.ok());
  EXPECT_TRUE(Assembler::create(config, &arena.value()).ok());
  EXPECT_EQ(arena->bytes_used(), Assembler::memory_bytes(config));
  Result<Arena> small = Arena::map(Assembler::memory_bytes(config) - 64);
  ASSERT_TRUE(small.ok());
  const auto refused = Assembler::create(config, &small.value());
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().status, Status::kOutOfArena);
}

TEST(AssemblerOutput, ImpossibleConfigurationsAreRefused) {
  const auto refused = [](auto change) {
    AssemblerConfig config = small_assembler();
    change(config);
    const auto result = Assembler::create(config);
    return !result.ok() && result.error().status == Status::kBadConfig;
  };
  EXPECT_TRUE(refused([](AssemblerConfig& c) { c.max_streams = 0; }));
  EXPECT_TRUE(refused([](AssemblerConfig& c) { c.max_streams = kMaxStreams + 1; }));
  EXPECT_TRUE(refused([](AssemblerConfig& c) { c.max_slices = 65'536; }));
  EXPECT_TRUE(refused([](AssemblerConfig& c) { c.max_frame_bytes = 0; }));
  EXPECT_TRUE(refused([](AssemblerConfig& c) { c.frames_in_assembly = 0; }));
  EXPECT_TRUE(refused([](AssemblerConfig& c) { c.frames_in_assembly = 9; }));
  EXPECT_TRUE(refused([](AssemblerConfig& c) { c.output_frames = 0; }));
  EXPECT_TRUE(refused([](AssemblerConfig& c) { c.held_frames = 0; }));
  EXPECT_TRUE(refused([](AssemblerConfig& c) { c.deadline_ns = -1; }));
}

TEST(AssemblerOutput, WaitEndsByAFrameByInterruptAndByTime) {
  AssemblerBench bench;
  EXPECT_FALSE(bench.assembler->wait(kMs));
  bench.assembler->interrupt();
  EXPECT_FALSE(bench.assembler->wait(60'000 * kMs));
  std::thread producer([&bench] { bench.frame(3); });
  const FrameRef frame = bench.assembler->wait(60'000 * kMs);
  producer.join();
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->frame, 3U);
}

TEST(AssemblerOutput, ADeadlineWakesTheConsumer) {
  AssemblerBench bench;
  bench.slice(3, 0);
  std::atomic<bool> woken{false};
  std::thread consumer([&] {
    if (bench.assembler->wait(60'000 * kMs)) woken.store(true);
  });
  std::this_thread::sleep_for(std::chrono::milliseconds(30));
  bench.advance(small_assembler().deadline_ns);
  for (int i = 0; i < 10'000 && !woken.load(); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  EXPECT_TRUE(woken.load());
  bench.assembler->interrupt();
  consumer.join();
}

// The same threads as in the receiver, without LCM in between: ThreadSanitizer sees all of it.
TEST(AssemblerOutput, ReceivingConsumingAndWatchingThreadsShareNothingUnguarded) {
  AssemblerConfig config = small_assembler();
  config.output_frames = 2;
  config.held_frames = 1;
  AssemblerBench bench(config);
  constexpr std::uint32_t kFrames = 3000;
  std::atomic<bool> done{false};
  std::uint64_t wrong = 0;
  std::uint64_t taken = 0;
  std::thread consumer([&] {
    for (;;) {
      const bool finished = done.load();
      const FrameRef frame = bench.assembler->wait(kMs);
      if (!frame && finished) return;
      if (!frame) continue;
      ++taken;
      for (std::uint16_t i = 0; i < frame->slice_count; ++i) {
        const auto expected = fake_packet(slice_info(7, frame->stream, frame->frame, i, 4));
        const auto bytes = frame->slice(i);
        if (!std::equal(bytes.begin(), bytes.end(), expected.begin(), expected.end())) ++wrong;
      }
      bench.assembler->count_unknown_keys(frame->stream, 1);
    }
  });
  std::uint64_t unbalanced = 0;
  std::thread watcher([&] {
    while (!done.load()) {
      const StreamStatistics s = bench.stream();
      if (s.slices_received < s.slices_delivered) ++unbalanced;
      if (s.frames_complete * 4 != s.slices_delivered) ++unbalanced;
      std::this_thread::yield();
    }
  });
  for (std::uint32_t number = 0; number < kFrames; ++number) {
    for (const std::uint16_t stream : std::array<std::uint16_t, 2>{1, 2}) {
      bench.push(key_info(7, stream, number));
      for (std::uint16_t i = 0; i < 4; ++i) bench.push(slice_info(7, stream, number, i, 4));
    }
    if (number % 3 == 0) std::this_thread::yield();
  }
  done.store(true);
  consumer.join();
  watcher.join();
  EXPECT_EQ(wrong, 0U);
  EXPECT_EQ(unbalanced, 0U);
  const ReceiverStatistics all = bench.assembler->statistics();
  EXPECT_EQ(all.streams[0].frames_complete, kFrames);
  EXPECT_EQ(all.streams[1].frames_complete, kFrames);
  EXPECT_EQ(all.streams[0].frames_taken + all.streams[1].frames_taken, taken);
  EXPECT_EQ(all.streams[0].frames_skipped + all.streams[1].frames_skipped + taken, 2 * kFrames);
  EXPECT_EQ(all.streams[0].unknown_keys + all.streams[1].unknown_keys, taken);
}

TEST(AssemblerOutput, JitterIgnoresTheClockOffsetAndSeesTheVariation) {
  AssemblerBench steady;
  AssemblerBench uneven;
  for (std::uint32_t number = 0; number < 200; ++number) {
    steady.now_ns += 33'333'333;
    steady.frame(number);
    uneven.now_ns += number % 2 == 0 ? 23'333'333 : 43'333'333;
    uneven.frame(number);
  }
  EXPECT_LT(steady.stream().jitter_ns, 1000.0);
  EXPECT_NEAR(uneven.stream().jitter_ns, 10e6, 0.1e6);
}

TEST(AssemblerOutput, CaptureLatencyIsMeasuredOnlyOnASharedClock) {
  AssemblerBench unknown;
  unknown.frame(3);
  EXPECT_EQ(unknown.stream().capture.count(), 0U);
  AssemblerConfig config = small_assembler();
  config.stamp_clock = StampClock::kMonotonic;
  AssemblerBench shared(config);
  shared.frame(3);
  EXPECT_EQ(shared.stream().capture.count(), 1U);
  EXPECT_EQ(shared.stream().capture.max_ns(), 1'000 * kMs - 3 * 33'333'333LL);
}

}  // namespace planecast
