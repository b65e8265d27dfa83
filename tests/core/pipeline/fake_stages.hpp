// A four-stage chain whose stages only leave traces, so that order, skipping and ownership show.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <iterator>
#include <span>
#include <thread>
#include <utility>
#include <vector>

#include "core/base/arena.hpp"
#include "core/pipeline/stage_runner.hpp"

namespace planecast::test {

struct FakeSlot {
  std::uint64_t frame = 0;
  std::uint64_t trace = 0;  ///< a hash of the stages passed and what each had seen before
  std::uint32_t visited = 0;
};

/// Fails every frame whose number is 2 modulo 7, if told to; else folds its own history into the
/// trace, so that two runs agree only when each stage met the same frames in the same order.
struct FakeStage {
  static constexpr const char* kName = "fake";
  std::uint32_t number = 0;
  bool fails = false;
  std::uint64_t history = 0;
  std::function<void()> extra;  ///< planted behaviour of a test

  Status process(FakeSlot& slot) noexcept {
    if (extra) extra();
    ++slot.visited;
    if (fails && slot.frame % 7 == 2) return Status::kBoundExceeded;
    history = history * 6364136223846793005ULL + slot.frame + 1;
    slot.trace = (slot.trace ^ history) * 1099511628211ULL + number;
    return Status::kOk;
  }
};
static_assert(Stage<FakeStage, FakeSlot>);

/// What the consumer saw of a frame.
struct Seen {
  std::uint64_t frame;
  std::uint64_t trace;
  Status status;
  std::uint32_t visited;
  bool operator==(const Seen&) const = default;
};

class FakeChain {
 public:
  static constexpr std::uint32_t kStages = 4;

  explicit FakeChain(RunnerConfig config)
      : slots(config.slots),
        arena_(std::move(Arena::map(StageRunner::memory_bytes(config, kStages)).value())) {
    std::array<StageRef, kStages> refs;
    for (std::uint32_t i = 0; i < kStages; ++i) {
      stages[i].number = i + 1;
      refs[i] = make_stage_ref(stages[i], std::span<FakeSlot>(slots));
    }
    init_status = runner.init(arena_, config, refs);
    arena_.seal();
  }

  /// Source: claims and submits a frame; false when it was dropped.
  bool offer(std::uint64_t frame, bool wait = false, Status status = Status::kOk) {
    const auto handle = wait ? runner.claim_wait() : runner.claim();
    if (!handle) return false;
    slots[*handle] = {.frame = frame, .trace = 0, .visited = 0};
    return runner.submit(*handle, status) == Status::kOk;
  }

  Seen take(std::uint32_t handle) {
    const FakeSlot& slot = slots[handle];
    const Seen seen{slot.frame, slot.trace, runner.status(handle), slot.visited};
    runner.release(handle);
    return seen;
  }

  std::vector<Seen> take_all() {
    std::vector<Seen> all;
    std::uint32_t handle = 0;
    while (runner.try_pop_done(handle)) all.push_back(take(handle));
    return all;
  }

  const Arena& arena() const { return arena_; }

  std::vector<FakeSlot> slots;
  std::array<FakeStage, kStages> stages;
  Status init_status = Status::kBadConfig;

 private:
  Arena arena_;

 public:
  StageRunner runner;  ///< last, so that it stops before what it works on goes
};

inline RunnerConfig config_of(RunMode mode, std::uint32_t slots = 4) {
  return {.slots = slots, .mode = mode};
}

/// Runs frames first..first+count-1 through a started chain, none dropped, and stops it.
inline std::vector<Seen> run_frames(FakeChain& chain, RunMode mode, std::uint64_t first,
                                    std::uint64_t count) {
  std::vector<Seen> seen;
  EXPECT_TRUE(chain.runner.start().ok());
  if (mode == RunMode::kInline) {
    for (std::uint64_t i = first; i < first + count; ++i) {
      EXPECT_TRUE(chain.offer(i));
      for (const Seen& one : chain.take_all()) seen.push_back(one);
    }
    chain.runner.stop();
    return seen;
  }
  std::thread consumer([&] {
    std::uint32_t handle = 0;
    while (chain.runner.pop_done(handle)) seen.push_back(chain.take(handle));
  });
  for (std::uint64_t i = first; i < first + count; ++i) EXPECT_TRUE(chain.offer(i, true));
  chain.runner.stop();
  consumer.join();
  return seen;
}

inline void expect_balance(const FrameTotals& totals) {
  EXPECT_EQ(totals.in, totals.ok + totals.failed + totals.dropped);
  EXPECT_EQ(totals.in_flight(), 0U);
}

/// Threads of this process.
inline std::size_t thread_count() {
  const std::filesystem::directory_iterator tasks("/proc/self/task");
  return static_cast<std::size_t>(std::distance(begin(tasks), end(tasks)));
}

/// Threads before a test makes its own. A first thread has come and gone: some runtimes, such as
/// ThreadSanitizer's, start a helper along with it and keep that for good.
inline std::size_t threads_before() {
  std::thread([] {}).join();
  std::size_t least = thread_count();
  for (int i = 0; i < 1000; ++i) least = std::min(least, thread_count());
  return least;
}

/// True when no more than `expected` threads are left. The kernel lists a thread for a moment after
/// it was joined, so this looks again, often enough that only a leaked thread can fail it.
inline bool threads_gone(std::size_t expected) {
  for (int i = 0; i < 100'000 && thread_count() > expected; ++i) std::this_thread::yield();
  return thread_count() <= expected;
}

}  // namespace planecast::test
