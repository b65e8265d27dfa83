#include "core/ring/spsc_ring.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <limits>
#include <thread>

#include "core/base/random.hpp"
#include "tests/support/sanitized.hpp"

namespace planecast {
namespace {

constexpr std::uint32_t kMillion = test::kSanitized ? 100'000 : 1'000'000;
constexpr std::uint32_t kNearWrap = std::numeric_limits<std::uint32_t>::max() - 2;

template <class Memory>
class RingOver {
 public:
  explicit RingOver(std::uint32_t capacity, std::uint32_t first_index = 0)
      : arena_(std::move(Arena::map(std::size_t{1} << 20U).value())) {
    EXPECT_EQ(ring_.init(arena_, capacity, first_index), Status::kOk);
  }
  BasicSpscRing<Memory>& operator*() { return ring_; }
  BasicSpscRing<Memory>* operator->() { return &ring_; }

 private:
  Arena arena_;
  BasicSpscRing<Memory> ring_;
};
using Ring = RingOver<MachineMemory>;

/// A kernel without membarrier: the producer fences.
struct FencedMemory : MachineMemory {
  static bool asymmetric() noexcept { return false; }
};
/// A kernel that grants the registration and then refuses the barrier: the ring is polled.
struct RefusedMemory : MachineMemory {
  static bool asymmetric() noexcept { return true; }
  static bool heavy_fence() noexcept { return false; }
};

TEST(SpscRing, CapacityIsRoundedUpToAPowerOfTwo) {
  EXPECT_EQ(Ring(1)->capacity(), 1U);
  EXPECT_EQ(Ring(5)->capacity(), 8U);
  EXPECT_EQ(Ring(64)->capacity(), 64U);
}

TEST(SpscRing, RefusesNoCapacityTooMuchAndTooLittleMemory) {
  SpscRing ring;
  Arena arena = std::move(Arena::map(64).value());
  EXPECT_EQ(ring.init(arena, 0), Status::kBadConfig);
  EXPECT_EQ(ring.init(arena, SpscRing::kMaxCapacity + 1), Status::kBadConfig);
  EXPECT_EQ(ring.init(arena, 17), Status::kOutOfArena);
}

TEST(SpscRing, WithoutInitIsBothFullAndEmpty) {
  SpscRing ring;
  std::uint32_t handle = 0;
  EXPECT_FALSE(ring.try_push(1));
  EXPECT_FALSE(ring.try_pop(handle));
}

TEST(SpscRing, FillsToCapacityAndEmptiesInOrder) {
  for (const std::uint32_t first_index : {0U, kNearWrap, 1U << 31U}) {
    Ring ring(4, first_index);
    std::uint32_t handle = 0;
    for (std::uint32_t round = 0; round < 5; ++round) {
      EXPECT_FALSE(ring->try_pop(handle));
      for (std::uint32_t i = 0; i < 4; ++i) EXPECT_TRUE(ring->try_push(10 * round + i));
      EXPECT_FALSE(ring->try_push(99));
      EXPECT_EQ(ring->size(), 4U);
      for (std::uint32_t i = 0; i < 4; ++i) {
        ASSERT_TRUE(ring->try_pop(handle));
        EXPECT_EQ(handle, 10 * round + i);
      }
    }
  }
}

TEST(SpscRing, OneFreedCellTakesExactlyOneMore) {
  Ring ring(2, kNearWrap);
  std::uint32_t handle = 0;
  ASSERT_TRUE(ring->try_push(1));
  ASSERT_TRUE(ring->try_push(2));
  for (std::uint32_t i = 3; i < 20; ++i) {
    EXPECT_FALSE(ring->try_push(i));
    ASSERT_TRUE(ring->try_pop(handle));
    EXPECT_EQ(handle, i - 2);
    EXPECT_TRUE(ring->try_push(i));
  }
}

// A model of two counters decides what each call must return.
TEST(SpscRing, RandomSingleThreadCallsFollowTheModel) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Pcg32 random(seed);
    const std::uint32_t capacity = 1U << random.below(5);
    Ring ring(capacity, 0U - random.below(50));
    std::uint32_t pushed = 0;
    std::uint32_t popped = 0;
    for (int step = 0; step < 2000; ++step) {
      if (random.below(2) == 0) {
        const bool room = pushed - popped < capacity;
        ASSERT_EQ(ring->try_push(pushed), room);
        pushed += room ? 1 : 0;
      } else {
        std::uint32_t handle = 0;
        ASSERT_EQ(ring->try_pop(handle), pushed != popped);
        if (pushed != popped) {
          ASSERT_EQ(handle, popped++);
        }
      }
      ASSERT_EQ(ring->size(), pushed - popped);
    }
  }
}

struct Traffic {
  std::uint32_t capacity;
  std::uint32_t spin_ns;
  bool waiting_consumer;
  bool halting_producer;
};

// Values are a sequence, so a lost, doubled, stale or swapped handle shows.
template <class Memory = MachineMemory>
void run_traffic(const Traffic& traffic, std::uint32_t count) {
  RingOver<Memory> ring(traffic.capacity, 0U - count / 2);
  ring->set_spin_ns(traffic.spin_ns);
  std::thread producer([&] {
    Pcg32 random(7);
    for (std::uint32_t i = 0; i < count;) {
      if (ring->try_push(i)) {
        ++i;
      } else {
        std::this_thread::yield();
      }
      if (traffic.halting_producer && random.below(64) == 0) std::this_thread::yield();
    }
    ring->close();
  });
  std::uint32_t expected = 0;
  std::uint32_t wrong = 0;
  std::uint32_t handle = 0;
  for (;;) {
    if (traffic.waiting_consumer) {
      if (!ring->pop_wait(handle)) break;
    } else if (!ring->try_pop(handle)) {
      if (expected == count) break;
      std::this_thread::yield();
      continue;
    }
    wrong += handle != expected ? 1 : 0;
    ++expected;
  }
  producer.join();
  EXPECT_EQ(expected, count);
  EXPECT_EQ(wrong, 0U);
}

TEST(SpscRing, MillionHandlesKeepTheirOrderWhilePolling) {
  run_traffic({256, 0, false, false}, kMillion);
}

TEST(SpscRing, MillionHandlesKeepTheirOrderWhileSleeping) {
  run_traffic({256, 0, true, true}, kMillion);
}

TEST(SpscRing, MillionHandlesKeepTheirOrderWhileSpinning) {
  run_traffic({64, 20'000, true, false}, kMillion);
}

TEST(SpscRing, MillionHandlesKeepTheirOrderWithoutTheKernelsBarrier) {
  run_traffic<FencedMemory>({256, 0, true, true}, kMillion);
  run_traffic<RefusedMemory>({256, 0, true, true}, kMillion);
}

TEST(SpscRing, NarrowRingKeepsTheOrder) {
  run_traffic({1, 0, true, false}, 100'000);
}

// Each handle is answered before the next is sent, so every hand-off meets a consumer that is about
// to sleep: a lost wake-up would hang here.
template <class Memory>
void ping_pong() {
  constexpr std::uint32_t kRounds = 20'000;
  RingOver<Memory> there(2);
  RingOver<Memory> back(2);
  std::thread echo([&] {
    std::uint32_t handle = 0;
    while (there->pop_wait(handle)) EXPECT_TRUE(back->try_push(handle));
  });
  std::uint32_t answered = 0;
  for (std::uint32_t i = 0; i < kRounds; ++i) {
    std::uint32_t handle = 0;
    ASSERT_TRUE(there->try_push(i));
    ASSERT_TRUE(back->pop_wait(handle));
    answered += handle == i ? 1 : 0;
  }
  there->close();
  echo.join();
  EXPECT_EQ(answered, kRounds);
}

TEST(SpscRing, PingPongLosesNoWakeUp) {
  ping_pong<MachineMemory>();
  ping_pong<FencedMemory>();
  ping_pong<RefusedMemory>();
}

TEST(SpscRing, CloseEndsAWaitWheneverItComes) {
  for (int round = 0; round < 2000; ++round) {
    Ring ring(4);
    if (round % 3 == 0) ring->set_spin_ns(5'000);
    std::atomic<bool> inside{false};
    std::thread consumer([&] {
      std::uint32_t handle = 0;
      inside.store(true);
      EXPECT_FALSE(ring->pop_wait(handle));
    });
    // Odd rounds close while the consumer is on its way to sleep, even ones perhaps before.
    while (round % 2 == 1 && !inside.load()) std::this_thread::yield();
    ring->close();
    consumer.join();
  }
}

// Push and close strike at a random moment of the consumer's way into its wait.
TEST(SpscRing, HandlePushedJustBeforeCloseIsDelivered) {
  constexpr std::uint32_t kRounds = 10'000;
  Ring ring(4);
  std::atomic<std::uint32_t> begun{0};
  std::atomic<std::uint32_t> ended{0};
  std::uint32_t delivered = 0;
  std::uint32_t closed = 0;
  std::thread consumer([&] {
    for (std::uint32_t round = 1; round <= kRounds; ++round) {
      while (begun.load() != round) std::this_thread::yield();
      std::uint32_t handle = 0;
      if (ring->pop_wait(handle)) ++delivered;
      if (!ring->try_pop(handle) && !ring->pop_wait(handle)) ++closed;
      ended.store(round);
    }
  });
  Pcg32 random(11);
  for (std::uint32_t round = 1; round <= kRounds; ++round) {
    begun.store(round);
    volatile std::uint32_t delay = random.below(200);
    while (delay > 0) delay = delay - 1;
    EXPECT_TRUE(ring->try_push(round));
    ring->close();
    while (ended.load() != round) std::this_thread::yield();
    ring->reopen();
  }
  consumer.join();
  EXPECT_EQ(delivered, kRounds);
  EXPECT_EQ(closed, kRounds);
}

TEST(SpscRing, ClosedRingStillDeliversWhatWasPushed) {
  Ring ring(4);
  std::uint32_t handle = 0;
  ASSERT_TRUE(ring->try_push(5));
  ASSERT_TRUE(ring->try_push(6));
  ring->close();
  EXPECT_TRUE(ring->pop_wait(handle));
  EXPECT_EQ(handle, 5U);
  EXPECT_TRUE(ring->pop_wait(handle));
  EXPECT_EQ(handle, 6U);
  EXPECT_FALSE(ring->pop_wait(handle));
  EXPECT_FALSE(ring->pop_wait(handle));
}

TEST(SpscRing, ReopenedRingWaitsAgain) {
  Ring ring(4);
  std::uint32_t handle = 0;
  ring->close();
  EXPECT_FALSE(ring->pop_wait(handle));
  ring->reopen();
  std::thread producer([&] { EXPECT_TRUE(ring->try_push(9)); });
  EXPECT_TRUE(ring->pop_wait(handle));
  EXPECT_EQ(handle, 9U);
  producer.join();
}

}  // namespace
}  // namespace planecast
