// Small programs over the ring and the slot pool that relacy runs in many orders. Each is written
// so that any lost, doubled, stale or torn handle, and any lost wake, ends it.
#pragma once

#include "tests/core/ring/model/model_memory.hpp"

namespace planecast::model {

template <class Suite, int kThreads>
struct Simulated : rl::test_suite<Suite, kThreads> {
  Threads in_this_run;
  void before() { threads = &in_this_run; }
};

/// A producer pushes 1..kItems through a ring of two cells, then closes it; the consumer sleeps
/// whenever it is empty and must get all of them, in order, and then the end.
template <class Memory>
struct Stream : Simulated<Stream<Memory>, 2> {
  static constexpr std::uint32_t kItems = 4;
  ModelPlain<std::uint32_t> cells[2];
  BasicSpscRing<Memory> ring;

  void before() {
    Simulated<Stream, 2>::before();
    ring.adopt(cells, 0U - 2U);  // the counters wrap on the way
  }
  void thread(unsigned index) {
    this->in_this_run.enter();
    if (index == 0) {
      for (std::uint32_t i = 1; i <= kItems; ++i)
        while (!ring.try_push(i)) rl::yield(1, RL_INFO);
      ring.close();
      return;
    }
    std::uint32_t got = 0;
    for (std::uint32_t i = 1; i <= kItems; ++i) {
      RL_ASSERT(ring.pop_wait(got));
      RL_ASSERT(got == i);
    }
    RL_ASSERT(!ring.pop_wait(got));
  }
};

/// One item and no close: only the push can wake the consumer.
template <class Memory>
struct OnePush : Simulated<OnePush<Memory>, 2> {
  ModelPlain<std::uint32_t> cells[1];
  BasicSpscRing<Memory> ring;

  void before() {
    Simulated<OnePush, 2>::before();
    ring.adopt(cells);
  }
  void thread(unsigned index) {
    this->in_this_run.enter();
    if (index == 0) {
      RL_ASSERT(ring.try_push(7));
      return;
    }
    std::uint32_t got = 0;
    RL_ASSERT(ring.pop_wait(got));
    RL_ASSERT(got == 7);
  }
};

/// A third thread closes while the other two work: what was pushed before is still delivered, the
/// consumer always ends.
template <class Memory>
struct OtherCloses : Simulated<OtherCloses<Memory>, 3> {
  ModelPlain<std::uint32_t> cells[2];
  BasicSpscRing<Memory> ring;
  ModelAtomic<std::uint32_t> pushed{0};

  void before() {
    Simulated<OtherCloses, 3>::before();
    ring.adopt(cells);
  }
  void thread(unsigned index) {
    this->in_this_run.enter();
    if (index == 0) {
      RL_ASSERT(ring.try_push(1));
      pushed.store(1, std::memory_order::release);
    } else if (index == 1) {
      // Seen pushed before the close: must be delivered before the end.
      const bool owed = pushed.load(std::memory_order::acquire) != 0;
      ring.close();
      closed_after_push.store(owed ? 1 : 0, std::memory_order::release);
    } else {
      std::uint32_t got = 0;
      std::uint32_t count = 0;
      while (ring.pop_wait(got)) {
        RL_ASSERT(got == 1);
        ++count;
      }
      RL_ASSERT(count <= 1);
      taken.store(count, std::memory_order::relaxed);
    }
  }
  void after() {
    const std::uint32_t owed = closed_after_push.load(std::memory_order::relaxed);
    RL_ASSERT(taken.load(std::memory_order::relaxed) >= owed);
  }
  ModelAtomic<std::uint32_t> closed_after_push{0};
  ModelAtomic<std::uint32_t> taken{0};
};

/// A source with one slot that drops every frame but the first, and an onlooker: who sees a drop
/// also sees the offer behind it, or frames in flight would turn negative.
template <class Memory>
struct Counts : Simulated<Counts<Memory>, 2> {
  ModelPlain<std::uint32_t> free[1], returned[1];
  ModelAtomic<std::uint32_t> claimed[1] = {0};
  BasicSlotPool<Memory> pool;

  void before() {
    Simulated<Counts, 2>::before();
    pool.adopt(free, claimed, returned);
  }
  void thread(unsigned index) {
    this->in_this_run.enter();
    if (index == 0) {
      for (int frame = 0; frame < 3; ++frame) RL_ASSERT(pool.claim().has_value() == (frame == 0));
    } else {
      std::uint64_t dropped = 0;
      while ((dropped = pool.dropped()) == 0) rl::yield(1, RL_INFO);
      RL_ASSERT(pool.offered() > dropped);
    }
  }
};

/// Two jobs in a row, shared with a helper that sleeps, comes late or takes all, then the end: each
/// piece is done once, of the job that was given, and its plain results are there afterwards.
template <class Memory>
struct SharedJobs : Simulated<SharedJobs<Memory>, 2> {
  static constexpr std::uint32_t kPieces = 2, kJobs = 2;
  struct Job {
    ModelPlain<std::uint32_t> factor, result[kPieces];
  };
  Job jobs[kJobs];
  BasicSharedPieces<Memory> pieces;

  static void work(void* job, std::uint32_t piece, std::uint32_t) noexcept {
    auto& self = *static_cast<Job*>(job);
    self.result[piece] = self.result[piece] + self.factor * (piece + 1);
  }
  void thread(unsigned index) {
    this->in_this_run.enter();
    if (index == 1) {
      pieces.help();
      return;
    }
    for (std::uint32_t n = 0; n < kJobs; ++n) {
      jobs[n].factor = n + 1;
      for (auto& result : jobs[n].result) result = 0;
      pieces.run(kPieces, &SharedJobs::work, &jobs[n]);
      for (std::uint32_t i = 0; i < kPieces; ++i) RL_ASSERT(jobs[n].result[i] == (n + 1) * (i + 1));
    }
    pieces.end();
  }
};

/// A source and a last stage. The source fills slots (plain memory) and must find none
/// that the last stage still reads.
template <class Memory>
struct Pool : Simulated<Pool<Memory>, 2> {
  static constexpr std::uint32_t kSlots = 2;
  static constexpr std::uint32_t kFrames = 4;
  ModelPlain<std::uint32_t> free[kSlots], returned[kSlots], handles[kSlots];
  ModelAtomic<std::uint32_t> claimed[kSlots] = {0, 0};
  ModelPlain<std::uint32_t> slots[kSlots];
  BasicSlotPool<Memory> pool;
  BasicSpscRing<Memory> ring;

  void before() {
    Simulated<Pool, 2>::before();
    pool.adopt(free, claimed, returned);
    ring.adopt(handles);
  }
  void thread(unsigned index) {
    this->in_this_run.enter();
    if (index == 0) {
      source();
    } else {
      last_stage();
    }
  }
  void source() {
    for (std::uint32_t frame = 1; frame <= kFrames; ++frame) {
      const auto handle = frame % 2 == 0 ? pool.claim() : pool.claim_wait();
      RL_ASSERT(handle.has_value() || frame % 2 == 0);
      if (!handle) continue;
      slots[*handle] = frame;
      RL_ASSERT(ring.try_push(*handle));  // holds all handles: never full
    }
    ring.close();
  }
  void last_stage() {
    std::uint32_t handle = 0;
    std::uint32_t before = 0;
    while (ring.pop_wait(handle)) {
      const std::uint32_t frame = slots[handle];
      RL_ASSERT(frame > before);
      before = frame;
      RL_ASSERT(pool.release(handle));
    }
  }
};

}  // namespace planecast::model
