// The heap guard proves that it catches what it must, then that the runner gives it nothing to
// catch.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/mman.h>
#include <unistd.h>

#include <condition_variable>
#include <cstdlib>
#include <mutex>
#include <new>
#include <thread>

#include "tests/core/pipeline/fake_stages.hpp"
#include "tests/support/heap_guard.hpp"

namespace planecast {
namespace {

using test::FakeChain;
using test::HeapGuard;
using test::HeapGuardTotals;

RunnerConfig guarded_config() {
  return {.slots = 4,
          .mode = RunMode::kThreads,
          .on_thread_start = HeapGuard::arm_this_thread,
          .on_thread_stop = HeapGuard::disarm_this_thread};
}

// A store that the compiler cannot see through: a planted allocation must not be optimised away.
void* volatile runner_sink = nullptr;

/// Runs `count` frames through four stages, `planted` being called by the second, and returns what
/// the guard saw on the stages' threads.
HeapGuardTotals run_guarded(std::uint64_t count, std::function<void()> planted = {}) {
  FakeChain chain(guarded_config());
  chain.stages[1].extra = std::move(planted);
  HeapGuard::reset();
  EXPECT_TRUE(chain.runner.start().ok());
  std::uint64_t seen = 0;
  std::thread consumer([&] {
    std::uint32_t handle = 0;
    while (chain.runner.pop_done(handle)) seen += chain.take(handle).visited == 4 ? 1 : 0;
  });
  for (std::uint64_t i = 0; i < count; ++i) EXPECT_TRUE(chain.offer(i, true));
  chain.runner.stop();
  consumer.join();
  EXPECT_EQ(seen, count);
  return HeapGuard::totals();
}

TEST(HeapGuard, TenThousandFramesThroughFourStagesDoNothingForbidden) {
  PLANECAST_NEED_HEAP_GUARD();
  const HeapGuardTotals totals = run_guarded(10'000);
  EXPECT_EQ(totals.allocations, 0U) << HeapGuard::first_offender();
  EXPECT_EQ(totals.frees, 0U) << HeapGuard::first_offender();
  EXPECT_EQ(totals.maps, 0U) << HeapGuard::first_offender();
  EXPECT_EQ(totals.blocks(), 0U) << HeapGuard::first_offender();
  EXPECT_EQ(HeapGuard::first_offender(), "");
}

TEST(HeapGuard, InlineRunOnTheCallersThreadDoesNothingForbidden) {
  PLANECAST_NEED_HEAP_GUARD();
  FakeChain chain({.slots = 2, .mode = RunMode::kInline});
  ASSERT_TRUE(chain.runner.start().ok());
  HeapGuard::reset();
  HeapGuard::arm_this_thread("inline");
  std::uint32_t handle = 0;
  bool good = true;
  for (std::uint64_t i = 0; i < 10'000; ++i) {
    good = chain.offer(i) && chain.runner.try_pop_done(handle) && good;
    chain.take(handle);
  }
  HeapGuard::disarm_this_thread();
  EXPECT_TRUE(good);
  EXPECT_EQ(HeapGuard::totals().sum(), 0U) << HeapGuard::first_offender();
}

TEST(HeapGuard, CatchesAPlantedMallocInAStageAndNamesThread) {
  PLANECAST_NEED_HEAP_GUARD();
  const HeapGuardTotals totals = run_guarded(10, [] { runner_sink = std::malloc(8); });
  EXPECT_EQ(totals.allocations, 10U);
  EXPECT_EQ(totals.sum(), 10U);
  const std::string offender = HeapGuard::first_offender();
  EXPECT_EQ(offender.find("malloc on thread 'fake'"), 0U) << offender;
  EXPECT_GT(std::count(offender.begin(), offender.end(), '\n'), 3) << offender;
}

TEST(HeapGuard, CatchesAPlantedFreeInAStage) {
  PLANECAST_NEED_HEAP_GUARD();
  std::vector<void*> blocks;
  for (int i = 0; i < 10; ++i) blocks.push_back(std::malloc(8));
  const HeapGuardTotals totals =
      run_guarded(10, [&blocks, i = std::size_t{0}]() mutable { std::free(blocks[i++]); });
  EXPECT_EQ(totals.frees, 10U);
  EXPECT_EQ(totals.sum(), 10U);
}

TEST(HeapGuard, CatchesNewAlignedNewCallocReallocAndMemalign) {
  PLANECAST_NEED_HEAP_GUARD();
  const HeapGuardTotals totals = run_guarded(1, [] {
    runner_sink = ::operator new(8);
    runner_sink = ::operator new (64, std::align_val_t{64});
    runner_sink = std::calloc(1, 8);
    runner_sink = std::realloc(nullptr, 8);
    runner_sink = std::aligned_alloc(64, 64);
    void* block = nullptr;
    if (posix_memalign(&block, 64, 64) == 0) runner_sink = block;
  });
  EXPECT_EQ(totals.allocations, 6U) << HeapGuard::first_offender();
}

TEST(HeapGuard, CatchesAPlantedMapping) {
  PLANECAST_NEED_HEAP_GUARD();
  const HeapGuardTotals totals = run_guarded(1, [] {
    void* at = mmap(nullptr, 4096, PROT_READ, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    munmap(at, 4096);
    runner_sink = sbrk(0);
  });
  EXPECT_EQ(totals.maps, 3U);
}

TEST(HeapGuard, CatchesAMutexWaitInAStageAndLetsAFreeMutexPass) {
  PLANECAST_NEED_HEAP_GUARD();
  std::mutex mutex;
  EXPECT_EQ(run_guarded(10, [&] { const std::scoped_lock lock(mutex); }).sum(), 0U);

  std::atomic<bool> waiting{false};
  mutex.lock();
  std::thread holder_stays([&] {
    // Gives the mutex away only once the guard has counted the wait, so no clock is involved.
    while (HeapGuard::totals().blocks() == 0) std::this_thread::yield();
    waiting.store(true);
  });
  std::thread run(
      [&] { EXPECT_EQ(run_guarded(1, [&] { const std::scoped_lock lock(mutex); }).blocks(), 1U); });
  holder_stays.join();
  mutex.unlock();
  run.join();
  EXPECT_TRUE(waiting.load());
}

TEST(HeapGuard, CatchesSleepConditionWaitPollReadAndWrite) {
  PLANECAST_NEED_HEAP_GUARD();
  const auto blocks = [](std::function<void()> planted) {
    return run_guarded(1, std::move(planted)).blocks();
  };
  const int null_device = open("/dev/null", O_RDWR);
  ASSERT_GE(null_device, 0);
  std::mutex mutex;
  std::condition_variable condition;
  EXPECT_EQ(blocks([] { std::this_thread::sleep_for(std::chrono::nanoseconds(1)); }), 1U);
  EXPECT_EQ(blocks([] { usleep(1); }), 1U);
  EXPECT_EQ(blocks([] { poll(nullptr, 0, 0); }), 1U);
  EXPECT_EQ(blocks([&] {
              char byte = 0;
              if (write(null_device, &byte, 1) == 1 && read(null_device, &byte, 1) == 0) return;
              std::abort();
            }),
            2U);
  EXPECT_EQ(blocks([&] {
              std::unique_lock lock(mutex);
              condition.wait_for(lock, std::chrono::nanoseconds(1));
            }),
            1U);
  close(null_device);
}

TEST(HeapGuard, CatchesAWaitOnAConditionThatAnotherThreadSignals) {
  PLANECAST_NEED_HEAP_GUARD();
  std::mutex mutex;
  std::condition_variable condition;
  bool ready = false;
  HeapGuard::reset();  // before the signaller looks for the first wait
  std::thread signaller([&] {
    while (HeapGuard::totals().blocks() == 0) std::this_thread::yield();
    const std::scoped_lock lock(mutex);
    ready = true;
    condition.notify_all();
  });
  const HeapGuardTotals totals = run_guarded(1, [&] {
    std::unique_lock lock(mutex);
    condition.wait(lock, [&] { return ready; });
  });
  signaller.join();
  EXPECT_GE(totals.blocks(), 1U);
}

TEST(HeapGuard, UnarmedThreadsAreFree) {
  PLANECAST_NEED_HEAP_GUARD();
  HeapGuard::reset();
  runner_sink = std::malloc(8);
  std::this_thread::sleep_for(std::chrono::nanoseconds(1));
  EXPECT_EQ(HeapGuard::totals().sum(), 0U);
  HeapGuard::arm_this_thread("main");
  runner_sink = std::malloc(8);
  HeapGuard::disarm_this_thread();
  runner_sink = std::malloc(8);
  EXPECT_EQ(HeapGuard::totals().allocations, 1U);
  EXPECT_EQ(HeapGuard::this_thread().allocations, 1U);
}

}  // namespace
}  // namespace planecast
