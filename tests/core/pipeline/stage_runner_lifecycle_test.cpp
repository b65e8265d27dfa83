// Start and stop of the runner in every state, with nothing lost and no thread left behind.
#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <vector>

#include "core/pipeline/stage_runner.hpp"
#include "tests/core/pipeline/fake_stages.hpp"

namespace planecast {
namespace {

using test::config_of;
using test::expect_balance;
using test::FakeChain;
using test::run_frames;
using test::Seen;
using test::threads_before;
using test::threads_gone;

TEST(StageRunnerLifecycle, StopBeforeStartAndTwiceDoesNothing) {
  StageRunner unborn;
  unborn.stop();
  FakeChain chain(config_of(RunMode::kThreads));
  chain.runner.stop();
  EXPECT_FALSE(chain.runner.running());
  ASSERT_TRUE(chain.runner.start().ok());
  chain.runner.stop();
  chain.runner.stop();
  EXPECT_FALSE(chain.runner.running());
}

TEST(StageRunnerLifecycle, StartBeforeInitNamesTheMistakeAndSecondStartDoesNothing) {
  StageRunner unborn;
  const Result<Done> early = unborn.start();
  ASSERT_FALSE(early.ok());
  EXPECT_EQ(early.error().status, Status::kBadConfig);
  EXPECT_FALSE(unborn.claim().has_value());

  static std::atomic<std::uint32_t> started;
  started = 0;
  RunnerConfig config = config_of(RunMode::kThreads);
  config.on_thread_start = [](const char*) { started.fetch_add(1); };
  FakeChain chain(config);
  ASSERT_TRUE(chain.runner.start().ok());
  ASSERT_TRUE(chain.runner.start().ok());
  EXPECT_EQ(started.load(), FakeChain::kStages);
}

TEST(StageRunnerLifecycle, SubmitWhileStoppedGivesTheSlotBackAsDropped) {
  for (const RunMode mode : {RunMode::kInline, RunMode::kThreads}) {
    FakeChain chain(config_of(mode, 2));
    for (int i = 0; i < 5; ++i) {
      const auto handle = chain.runner.claim();
      ASSERT_TRUE(handle.has_value());
      EXPECT_EQ(chain.runner.submit(*handle), Status::kStopped);
    }
    EXPECT_EQ(chain.runner.totals().dropped, 5U);
    expect_balance(chain.runner.totals());
  }
}

TEST(StageRunnerLifecycle, StopWhileFullEndsWithoutTheConsumerAndKeepsTheFrames) {
  for (const StopMode how : {StopMode::kDrain, StopMode::kDiscard}) {
    FakeChain chain(config_of(RunMode::kThreads, 5));
    std::atomic<bool> open{false};
    std::atomic<bool> inside{false};
    chain.stages[0].extra = [&] {
      inside.store(true);
      while (!open.load()) std::this_thread::yield();
    };
    ASSERT_TRUE(chain.runner.start().ok());
    for (std::uint64_t i = 0; i < 5; ++i) ASSERT_TRUE(chain.offer(i));
    EXPECT_FALSE(chain.offer(5));
    while (!inside.load()) std::this_thread::yield();
    std::thread opener([&] {
      // Discarding must already be in force when the first frame goes on.
      while (chain.runner.running()) std::this_thread::yield();
      open.store(true);
    });
    chain.runner.stop(how);
    opener.join();
    const std::vector<Seen> seen = chain.take_all();
    ASSERT_EQ(seen.size(), 5U);
    for (const Seen& one : seen) {
      EXPECT_EQ(one.status, how == StopMode::kDrain ? Status::kOk : Status::kStopped);
      const std::uint32_t begun = how == StopMode::kDrain ? 4U : (one.frame == 0 ? 1U : 0U);
      EXPECT_EQ(one.visited, begun);
    }
    std::uint32_t handle = 0;
    EXPECT_FALSE(chain.runner.pop_done(handle));
    expect_balance(chain.runner.totals());

    ASSERT_TRUE(chain.runner.start().ok());  // a discard ends with the stop that asked for it
    ASSERT_TRUE(chain.offer(9));
    ASSERT_TRUE(chain.runner.pop_done(handle));
    EXPECT_EQ(chain.take(handle).status, Status::kOk);
  }
}

TEST(StageRunnerLifecycle, StopWaitsForASubmitThatIsUnderWay) {
  FakeChain chain(config_of(RunMode::kInline));
  std::atomic<bool> inside{false};
  std::atomic<bool> finished{false};
  chain.stages[3].extra = [&] {
    inside.store(true);
    while (chain.runner.running()) std::this_thread::yield();
    for (int i = 0; i < 1000; ++i) std::this_thread::yield();
    finished.store(true);
  };
  ASSERT_TRUE(chain.runner.start().ok());
  std::thread source([&] { EXPECT_TRUE(chain.offer(0)); });
  while (!inside.load()) std::this_thread::yield();
  chain.runner.stop();
  EXPECT_TRUE(finished.load());
  EXPECT_EQ(chain.take_all().size(), 1U);
  source.join();
}

TEST(StageRunnerLifecycle, RestartsAfterStopWithoutLeakingThreadsOrFrames) {
  const std::size_t before = threads_before();
  for (const RunMode mode : {RunMode::kInline, RunMode::kThreads}) {
    FakeChain chain(config_of(mode));
    std::uint64_t next = 0;
    for (int round = 0; round < 50; ++round, next += 20) {
      const std::vector<Seen> seen = run_frames(chain, mode, next, 20);
      ASSERT_EQ(seen.size(), 20U);
      for (std::size_t i = 0; i < 20; ++i) ASSERT_EQ(seen[i].frame, next + i);
      ASSERT_TRUE(threads_gone(before));
    }
    EXPECT_EQ(chain.runner.totals().ok, next);
    expect_balance(chain.runner.totals());
  }
}

TEST(StageRunnerLifecycle, FramesLeftInDoneSurviveARestart) {
  FakeChain chain(config_of(RunMode::kThreads, 4));
  ASSERT_TRUE(chain.runner.start().ok());
  ASSERT_TRUE(chain.offer(1));
  ASSERT_TRUE(chain.offer(2));
  chain.runner.stop();
  ASSERT_TRUE(chain.runner.start().ok());
  ASSERT_TRUE(chain.offer(3));
  chain.runner.stop();
  const std::vector<Seen> seen = chain.take_all();
  ASSERT_EQ(seen.size(), 3U);
  EXPECT_EQ(seen[2].frame, 3U);
}

// Stop and start strike the source and the consumer at random moments: whatever was accepted comes
// out, in order, and the sums agree.
TEST(StageRunnerLifecycle, StopAndStartAtAnyMomentLoseNothing) {
  FakeChain chain(config_of(RunMode::kThreads, 3));
  std::atomic<bool> finished{false};
  std::atomic<std::uint64_t> accepted{0};
  std::thread source([&] {
    for (std::uint64_t i = 0; !finished.load(); ++i) {
      if (chain.offer(i)) accepted.fetch_add(1);
      std::this_thread::yield();
    }
  });
  std::vector<Seen> seen;
  std::thread consumer([&] {
    std::uint32_t handle = 0;
    while (!finished.load()) {
      if (chain.runner.pop_done(handle)) {
        seen.push_back(chain.take(handle));
      } else {
        std::this_thread::yield();
      }
    }
  });
  for (int round = 0; round < 300; ++round) {
    ASSERT_TRUE(chain.runner.start().ok());
    for (int i = 0; i < round % 7; ++i) std::this_thread::yield();
    chain.runner.stop(round % 2 == 0 ? StopMode::kDrain : StopMode::kDiscard);
  }
  finished.store(true);
  source.join();
  consumer.join();
  for (const Seen& one : chain.take_all()) seen.push_back(one);
  EXPECT_EQ(seen.size(), accepted.load());
  for (std::size_t i = 1; i < seen.size(); ++i) ASSERT_LT(seen[i - 1].frame, seen[i].frame);
  expect_balance(chain.runner.totals());
}

TEST(StageRunnerLifecycle, DestructionWhileRunningEndsTheThreads) {
  const std::size_t before = threads_before();
  {
    FakeChain chain(config_of(RunMode::kThreads));
    ASSERT_TRUE(chain.runner.start().ok());
    chain.offer(1);
    chain.offer(2);
  }
  EXPECT_TRUE(threads_gone(before));
}

TEST(StageRunnerLifecycle, StopWakesASourceThatWaitsForASlot) {
  FakeChain chain(config_of(RunMode::kThreads, 1));
  ASSERT_TRUE(chain.runner.start().ok());
  ASSERT_TRUE(chain.offer(0));
  std::thread source([&] { EXPECT_FALSE(chain.offer(1, true)); });
  while (chain.runner.totals().in < 2) std::this_thread::yield();
  chain.runner.stop();
  source.join();
  EXPECT_EQ(chain.take_all().size(), 1U);
  expect_balance(chain.runner.totals());
}

}  // namespace
}  // namespace planecast
