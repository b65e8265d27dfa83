#include "transport/overwrite_ring.hpp"

#include <gtest/gtest.h>

#include <array>
#include <thread>
#include <vector>

namespace planecast {

TEST(OverwriteRing, HandsOverOldestFirst) {
  std::array<OverwriteRing::Word, 4> words{};
  OverwriteRing ring;
  ring.init(words);
  std::vector<int> order;
  for (int i = 0; i < 4; ++i) order.push_back(ring.claim());
  EXPECT_EQ(ring.claim(), OverwriteRing::kNone);
  for (const int slot : {order[2], order[0], order[3], order[1]}) ring.publish(slot);
  EXPECT_EQ(ring.queued(), 4);
  for (const int slot : {order[2], order[0], order[3], order[1]}) EXPECT_EQ(ring.take(), slot);
  EXPECT_EQ(ring.take(), OverwriteRing::kNone);
}

TEST(OverwriteRing, ProducerTakesBackOnlyTheOldestNotBegun) {
  std::array<OverwriteRing::Word, 3> words{};
  OverwriteRing ring;
  ring.init(words);
  for (int i = 0; i < 3; ++i) ring.publish(ring.claim());
  const int being_read = ring.take();
  EXPECT_EQ(ring.claim(), OverwriteRing::kNone);
  EXPECT_EQ(ring.claim_oldest(3), OverwriteRing::kNone);
  const int oldest = ring.claim_oldest(2);
  EXPECT_NE(oldest, being_read);
  EXPECT_NE(oldest, OverwriteRing::kNone);
  ring.publish(oldest);
  ring.release(being_read);
  EXPECT_EQ(ring.claim(), being_read);
  EXPECT_NE(ring.take(), oldest);
  EXPECT_EQ(ring.take(), oldest);
}

// Each item is written to several plain words; a slot in two hands at once, a lost or doubled item,
// or a wrong order shows in the sums (and as a race under ThreadSanitizer).
TEST(OverwriteRing, TwoThreadsLoseNothingUncounted) {
  constexpr std::uint64_t kItems = 200'000;
  constexpr std::size_t kSlots = 4;
  struct Item {
    std::array<std::uint64_t, 8> copies{};
  };
  std::array<OverwriteRing::Word, kSlots> words{};
  OverwriteRing ring;
  ring.init(words);
  std::array<Item, kSlots> items{};
  std::atomic<bool> done{false};
  std::uint64_t taken = 0;
  bool torn = false;
  bool disordered = false;
  std::thread consumer([&] {
    std::uint64_t last = 0;
    for (;;) {
      const bool finished = done.load(std::memory_order_acquire);
      const int slot = ring.take();
      if (slot == OverwriteRing::kNone) {
        if (finished) return;
        std::this_thread::yield();
        continue;
      }
      const Item item = items[static_cast<std::size_t>(slot)];
      for (const std::uint64_t copy : item.copies) torn = torn || copy != item.copies[0];
      disordered = disordered || item.copies[0] <= last;
      last = item.copies[0];
      ++taken;
      ring.release(slot);
    }
  });
  std::uint64_t overwritten = 0;
  for (std::uint64_t number = 1; number <= kItems; ++number) {
    int slot = ring.claim();
    while (slot == OverwriteRing::kNone) {
      slot = ring.claim_oldest();
      if (slot != OverwriteRing::kNone) {
        ++overwritten;
      } else {
        slot = ring.claim();
      }
    }
    items[static_cast<std::size_t>(slot)].copies.fill(number);
    ring.publish(slot);
    if (number % 64 == 0) std::this_thread::yield();
  }
  done.store(true, std::memory_order_release);
  consumer.join();
  EXPECT_FALSE(torn);
  EXPECT_FALSE(disordered);
  EXPECT_EQ(taken + overwritten, kItems);
  EXPECT_GT(taken, 0U);
}

}  // namespace planecast
