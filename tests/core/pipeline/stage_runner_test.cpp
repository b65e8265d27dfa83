#include "core/pipeline/stage_runner.hpp"

#include <gtest/gtest.h>
#include <pthread.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <string>
#include <thread>
#include <vector>

#include "tests/core/pipeline/fake_stages.hpp"

namespace planecast {
namespace {

using test::config_of;
using test::expect_balance;
using test::FakeChain;
using test::FakeSlot;
using test::FakeStage;
using test::run_frames;
using test::Seen;

TEST(StageRunner, MemoryBytesIsWhatInitTakes) {
  for (const std::uint32_t slots : {1U, 3U, 6U, 64U}) {
    FakeChain chain(config_of(RunMode::kThreads, slots));
    ASSERT_EQ(chain.init_status, Status::kOk);
    EXPECT_EQ(chain.arena().bytes_used(), chain.arena().capacity());
    EXPECT_FALSE(chain.arena().failed());
  }
}

TEST(StageRunner, InitOverAMeasuringArenaCountsTheSame) {
  Arena arena = Arena::measuring();
  FakeStage stage;
  std::vector<FakeSlot> slots(6);
  const StageRef ref = make_stage_ref(stage, std::span<FakeSlot>(slots));
  StageRunner runner;
  EXPECT_EQ(runner.init(arena, {}, {&ref, 1}), Status::kOk);
  EXPECT_EQ(arena.bytes_needed(), StageRunner::memory_bytes({}, 1));
  EXPECT_FALSE(runner.start().ok());
}

TEST(StageRunner, RefusesBadConfigurations) {
  FakeStage stage;
  std::vector<FakeSlot> slots(6);
  const StageRef ref = make_stage_ref(stage, std::span<FakeSlot>(slots));
  const auto init = [&](RunnerConfig config, std::span<const StageRef> stages) {
    Arena arena = std::move(Arena::map(std::size_t{1} << 20U).value());
    StageRunner runner;
    return runner.init(arena, config, stages);
  };
  const std::vector<StageRef> too_many(StageRunner::kMaxStages + 1, ref);
  const StageRef hollow;
  EXPECT_EQ(init({}, {&ref, 1}), Status::kOk);
  EXPECT_EQ(init({}, {}), Status::kBadConfig);
  EXPECT_EQ(init({}, too_many), Status::kBadConfig);
  EXPECT_EQ(init({}, {&hollow, 1}), Status::kBadConfig);
  EXPECT_EQ(init({.slots = 0}, {&ref, 1}), Status::kBadConfig);
  EXPECT_EQ(init({.slots = 5000}, {&ref, 1}), Status::kBadConfig);
  EXPECT_EQ(init({.spin_ns = -2}, {&ref, 1}), Status::kBadConfig);
  EXPECT_EQ(init({.fifo_priority = 100}, {&ref, 1}), Status::kBadConfig);
  EXPECT_EQ(StageRunner::memory_bytes({.slots = 0}, 4), 0U);
}

TEST(StageRunner, TooSmallAnArenaIsRefused) {
  FakeStage stage;
  std::vector<FakeSlot> slots(6);
  const StageRef ref = make_stage_ref(stage, std::span<FakeSlot>(slots));
  Arena arena = std::move(Arena::map(StageRunner::memory_bytes({}, 1) - 1).value());
  StageRunner runner;
  EXPECT_EQ(runner.init(arena, {}, {&ref, 1}), Status::kOutOfArena);
  EXPECT_FALSE(runner.start().ok());
}

TEST(StageRunner, InlineAndThreadedRunsGiveTheSameFramesInTheSameOrder) {
  constexpr std::uint64_t kFrames = 5000;
  std::array<std::vector<Seen>, 2> seen;
  for (const RunMode mode : {RunMode::kInline, RunMode::kThreads}) {
    FakeChain chain(config_of(mode));
    chain.stages[1].fails = true;
    seen[static_cast<std::size_t>(mode)] = run_frames(chain, mode, 0, kFrames);
    const FrameTotals totals = chain.runner.totals();
    expect_balance(totals);
    EXPECT_EQ(totals.in, kFrames);
    EXPECT_EQ(totals.dropped, 0U);
    EXPECT_EQ(totals.failed, 714U);  // numbers 2, 9, ... 4993
  }
  ASSERT_EQ(seen[0].size(), kFrames);
  EXPECT_EQ(seen[0], seen[1]);
  for (std::size_t i = 0; i < kFrames; ++i) ASSERT_EQ(seen[0][i].frame, i);
}

TEST(StageRunner, FailedFramesFlowOnUntouchedInTheirPlace) {
  for (const RunMode mode : {RunMode::kInline, RunMode::kThreads}) {
    FakeChain chain(config_of(mode));
    chain.stages[1].fails = true;
    const std::vector<Seen> seen = run_frames(chain, mode, 0, 70);
    ASSERT_EQ(seen.size(), 70U);
    for (const Seen& one : seen) {
      const bool fails = one.frame % 7 == 2;
      EXPECT_EQ(one.status, fails ? Status::kBoundExceeded : Status::kOk);
      EXPECT_EQ(one.visited, fails ? 2U : 4U);
    }
    EXPECT_EQ(chain.runner.report(1).failed, 10U);
    EXPECT_EQ(chain.runner.report(1).ok, 60U);
    EXPECT_EQ(chain.runner.report(2).skipped, 10U);
    EXPECT_EQ(chain.runner.report(3).latency.count, 60U);
    EXPECT_GT(chain.runner.report(3).heartbeat_ns, 0);
  }
}

TEST(StageRunner, FrameSubmittedWithAStatusPassesAllStages) {
  FakeChain chain(config_of(RunMode::kInline));
  ASSERT_TRUE(chain.runner.start().ok());
  EXPECT_TRUE(chain.offer(1, false, Status::kFrameTooLarge));
  const std::vector<Seen> seen = chain.take_all();
  ASSERT_EQ(seen.size(), 1U);
  EXPECT_EQ(seen[0].status, Status::kFrameTooLarge);
  EXPECT_EQ(seen[0].visited, 0U);
  EXPECT_EQ(chain.runner.totals().failed, 1U);
}

// Source and slowest stage in lock step, two offers to each frame served: half of them, give or
// take the slots, must find none. The source only runs ahead when the chain is empty, so that the
// test cannot hang.
TEST(StageRunner, TwiceTooFastSourceLosesFramesOnlyAtTheClaimAndEveryOneIsCounted) {
  constexpr std::uint64_t kFrames = 4000;
  FakeChain chain(config_of(RunMode::kThreads));
  std::atomic<std::uint64_t> offered{0};
  std::atomic<std::uint64_t> served{0};
  std::atomic<std::uint64_t> taken{0};
  chain.stages[2].fails = true;
  chain.stages[2].extra = [&] {
    const std::uint64_t needed = std::min(2 * (served.load() + 1), kFrames);
    while (offered.load() < needed) std::this_thread::yield();
    served.fetch_add(1);
  };
  std::vector<Seen> seen;
  ASSERT_TRUE(chain.runner.start().ok());
  std::thread consumer([&] {
    std::uint32_t handle = 0;
    while (chain.runner.pop_done(handle)) {
      seen.push_back(chain.take(handle));
      taken.fetch_add(1);
    }
  });
  std::uint64_t accepted = 0;
  for (std::uint64_t i = 0; i < kFrames; ++i) {
    while (i >= 2 * served.load() + 2 && accepted > taken.load()) std::this_thread::yield();
    accepted += chain.offer(i) ? 1 : 0;
    offered.store(i + 1);
  }
  chain.runner.stop();
  consumer.join();
  const FrameTotals totals = chain.runner.totals();
  expect_balance(totals);
  EXPECT_EQ(totals.in, kFrames);
  EXPECT_EQ(totals.dropped, kFrames - accepted);
  EXPECT_EQ(totals.ok + totals.failed, accepted);
  EXPECT_GT(totals.failed, 0U);
  EXPECT_GE(totals.dropped, kFrames / 2 - 4);
  EXPECT_LE(totals.dropped, accepted + 2);
  EXPECT_EQ(seen.size(), accepted);
  for (std::size_t i = 1; i < seen.size(); ++i) ASSERT_LT(seen[i - 1].frame, seen[i].frame);
}

// Age in periods of the pipeline = frames delivered between a frame's claim and its own delivery.
// N slots hold it below N whatever the source's rate (Little's law), since the newest are dropped.
TEST(StageRunner, DataAgeUnderOverloadStaysBelowTheNumberOfSlots) {
  constexpr std::uint64_t kOffers = 20'000;
  for (const std::uint32_t slots : {1U, 2U, 4U, 7U}) {
    FakeChain chain(config_of(RunMode::kThreads, slots));
    std::vector<std::uint64_t> delivered_at_claim(slots, 0);
    std::atomic<std::uint64_t> delivered{0};
    std::uint64_t oldest = 0;
    ASSERT_TRUE(chain.runner.start().ok());
    std::thread consumer([&] {
      std::uint32_t handle = 0;
      while (chain.runner.pop_done(handle)) {
        oldest = std::max(oldest, delivered.load() - delivered_at_claim[handle]);
        delivered.fetch_add(1);
        chain.take(handle);
      }
    });
    for (std::uint64_t i = 0; i < kOffers; ++i) {
      const auto handle = chain.runner.claim();
      if (!handle) {
        std::this_thread::yield();
        continue;
      }
      delivered_at_claim[*handle] = delivered.load();
      chain.slots[*handle] = {.frame = i};
      ASSERT_EQ(chain.runner.submit(*handle), Status::kOk);
    }
    chain.runner.stop();
    consumer.join();
    EXPECT_LT(oldest, slots);
    expect_balance(chain.runner.totals());
  }
}

TEST(StageRunner, SecondReleaseIsRefused) {
  FakeChain chain(config_of(RunMode::kInline, 2));
  ASSERT_TRUE(chain.runner.start().ok());
  ASSERT_TRUE(chain.offer(0));
  std::uint32_t handle = 9;
  ASSERT_TRUE(chain.runner.try_pop_done(handle));
  EXPECT_TRUE(chain.runner.release(handle));
  EXPECT_FALSE(chain.runner.release(handle));
  EXPECT_FALSE(chain.runner.release(77));
  EXPECT_EQ(chain.runner.submit(77), Status::kBadConfig);
}

TEST(StageRunner, WatchdogSeesAStageThatHangsAndNotTheIdleOnes) {
  FakeChain chain(config_of(RunMode::kThreads));
  std::atomic<bool> open{false};
  std::atomic<bool> inside{false};
  chain.stages[1].extra = [&] {
    inside.store(true);
    while (!open.load()) std::this_thread::yield();
  };
  ASSERT_TRUE(chain.runner.start().ok());
  for (std::uint32_t i = 0; i < FakeChain::kStages; ++i) EXPECT_FALSE(chain.runner.stalled(i, 0));
  ASSERT_TRUE(chain.offer(0));
  while (!inside.load()) std::this_thread::yield();
  // Any time at all is too long for a limit of -1; no clock decides this test.
  EXPECT_TRUE(chain.runner.stalled(1, -1));
  EXPECT_TRUE(chain.runner.report(1).busy);
  EXPECT_FALSE(chain.runner.stalled(3, 0));
  EXPECT_FALSE(chain.runner.stalled(1, 3'600'000'000'000));
  open.store(true);
}

TEST(StageRunner, WorkersTellTheirNamesAndRefusedWishesAreFlags) {
  static std::atomic<int> started;
  static std::atomic<int> stopped;
  started = stopped = 0;
  RunnerConfig config = config_of(RunMode::kThreads);
  config.fifo_priority = 1;
  config.first_core = 1'000'000;
  config.on_thread_start = [](const char* name) {
    std::array<char, 16> own{};
    pthread_getname_np(pthread_self(), own.data(), own.size());
    if (std::string(own.data()) == name && own[0] == 'f') started.fetch_add(1);
  };
  config.on_thread_stop = [](const char*) { stopped.fetch_add(1); };
  FakeChain chain(config);
  ASSERT_TRUE(chain.runner.start().ok());
  EXPECT_EQ(started.load(), 4);
  EXPECT_FALSE(chain.runner.affinity_refused());  // the index wraps around the cores allowed
  chain.runner.stop();
  EXPECT_EQ(stopped.load(), 4);
  EXPECT_EQ(run_frames(chain, RunMode::kThreads, 0, 10).size(), 10U);
}

}  // namespace
}  // namespace planecast
