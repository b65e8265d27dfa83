// Stages over their deadline are counted, by themselves and from outside; and a stage that stalls
// costs a few frames, counted, and nothing afterwards. All on counts: time appears only as waits
// that are far longer than what they are compared with.
#include "core/pipeline/watchdog.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "tests/core/pipeline/fake_stages.hpp"

namespace planecast {
namespace {

using test::expect_balance;
using test::FakeChain;

constexpr std::int64_t kMillisecond = 1'000'000;

void pause_ms(int ms) {
  std::this_thread::sleep_for(std::chrono::milliseconds(ms));
}

/// Runs 20 frames through a chain whose third stage runs `planted` on each; frames late by stage.
std::array<std::uint64_t, FakeChain::kStages> late_by_stage(std::int64_t deadline_ns,
                                                            std::function<void()> planted) {
  for (const RunMode mode : {RunMode::kThreads, RunMode::kInline}) {
    RunnerConfig config = test::config_of(mode);
    config.deadline_ns = deadline_ns;
    FakeChain chain(config);
    chain.stages[2].extra = planted;
    EXPECT_EQ(test::run_frames(chain, mode, 0, 20).size(), 20U);
    std::array<std::uint64_t, FakeChain::kStages> late{};
    for (std::uint32_t i = 0; i < FakeChain::kStages; ++i) late[i] = chain.runner.report(i).late;
    if (mode == RunMode::kInline) return late;
    EXPECT_EQ(late[2] > 0, static_cast<bool>(planted) && deadline_ns > 0);
  }
  return {};
}

TEST(Deadline, NoFrameIsLateWithinItAndNoneIsCountedWithoutOne) {
  EXPECT_EQ(late_by_stage(3'600'000 * kMillisecond, {})[2], 0U);
  EXPECT_EQ(late_by_stage(0, [] { pause_ms(1); })[2], 0U);
}

TEST(Deadline, ASleepPlantedInAStageIsCountedInThatStageForEveryFrame) {
  const auto late = late_by_stage(2 * kMillisecond, [] { pause_ms(5); });
  EXPECT_EQ(late[2], 20U);
  EXPECT_LT(late[0] + late[1] + late[3], 20U) << "a busy machine may hold up another one, rarely";
}

TEST(Deadline, ANegativeOneIsRefused) {
  EXPECT_EQ(StageRunner::memory_bytes({.deadline_ns = -1}, 4), 0U);
}

TEST(Watchdog, TellsOnceOfAStageThatHangsAndAgainOfTheNextTime) {
  FakeChain chain(test::config_of(RunMode::kThreads));
  std::atomic<int> held{0};
  chain.stages[1].extra = [&] {
    while (held.load() != 0) pause_ms(1);
  };
  ASSERT_TRUE(chain.runner.start().ok());
  Watchdog watchdog(chain.runner, 20 * kMillisecond);
  pause_ms(50);
  EXPECT_EQ(watchdog.look(), 0U) << "stages without work are not silent";
  for (std::uint64_t round = 1; round <= 2; ++round) {
    held.store(1);
    ASSERT_TRUE(chain.offer(round));
    std::uint32_t fell = 0;
    for (int i = 0; i < 10'000 && fell == 0; ++i) {
      pause_ms(1);
      fell = watchdog.look();
    }
    EXPECT_EQ(fell, 1U << 1U);
    pause_ms(50);
    EXPECT_EQ(watchdog.look(), 0U) << "still the same silence";
    held.store(0);
    std::uint32_t handle = 0;
    ASSERT_TRUE(chain.runner.pop_done(handle));
    chain.take(handle);
    EXPECT_EQ(watchdog.look(), 0U);
    EXPECT_EQ(watchdog.silences(1), round);
  }
  EXPECT_EQ(watchdog.silences(0) + watchdog.silences(2) + watchdog.silences(3), 0U);
}

/// A source at a rate and a chain that keeps up with it, in periods instead of milliseconds: after
/// each offer everything that can move has moved.
struct Stall {
  std::uint64_t dropped = 0;             ///< frames that got no slot
  std::uint64_t dropped_after = 0;       ///< of those offered after the stall
  std::uint64_t periods_to_recover = 0;  ///< after the stall, until no frame was left waiting
  std::uint64_t delivered = 0;
};

/// Stage 1 holds one frame while `periods` more are offered.
Stall run_stall(std::uint32_t slots, std::uint64_t periods) {
  constexpr std::uint64_t kFrames = 60, kStalled = 20;
  const std::uint64_t end = kStalled + periods;  // the last frame offered during the stall
  FakeChain chain(test::config_of(RunMode::kThreads, slots));
  std::atomic<std::uint64_t> offered{0};
  std::atomic<bool> stalled{false};
  chain.stages[1].extra = [&, frame = std::uint64_t{0}]() mutable {
    if (frame++ != kStalled) return;
    stalled.store(true);
    while (offered.load() < end) std::this_thread::yield();
    stalled.store(false);
  };
  Stall out;
  EXPECT_TRUE(chain.runner.start().ok());
  bool recovered = false;
  for (std::uint64_t i = 0; i < kFrames; ++i) {
    const bool accepted = chain.offer(i);
    out.dropped += accepted ? 0 : 1;
    out.dropped_after += i > end && !accepted ? 1 : 0;
    offered.store(i);
    const auto all_moved = [&] {
      for (const auto& one : chain.take_all()) out.delivered += one.status == Status::kOk ? 1 : 0;
      return out.delivered + out.dropped == i + 1 || (stalled.load() && i < end);
    };
    while (!all_moved()) std::this_thread::yield();
    if (i >= end && !recovered) {
      recovered = chain.runner.totals().in_flight() == 0;
      out.periods_to_recover = i + 1 - end;
    }
  }
  chain.runner.stop();
  expect_balance(chain.runner.totals());
  EXPECT_EQ(chain.runner.totals().dropped, out.dropped) << "each lost frame is counted";
  EXPECT_EQ(out.delivered + out.dropped, kFrames);
  return out;
}

// At 30 Hz a stage that stalls for 100 ms sees three frames come, or four.
TEST(Stall, OfAHundredMillisecondsCostsAtMostFourFramesAndIsOverWithinTwoPeriods) {
  for (const std::uint32_t slots : {1U, 2U, 3U, 4U, 6U}) {
    const Stall stall = run_stall(slots, 4);
    EXPECT_EQ(stall.dropped, slots < 5 ? 5U - slots : 0U) << slots << " slots";
    EXPECT_LE(stall.dropped, 4U) << slots << " slots";
    EXPECT_EQ(stall.dropped_after, 0U) << slots << " slots";
    EXPECT_LE(stall.periods_to_recover, 2U) << slots << " slots";
  }
}

TEST(Stall, OfHalfASecondShowsThatTheCountGrowsWithTheStall) {
  EXPECT_EQ(run_stall(4, 15).dropped, 15U - 3U);
}

}  // namespace
}  // namespace planecast
