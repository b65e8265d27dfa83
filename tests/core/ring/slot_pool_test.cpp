#include "core/ring/slot_pool.hpp"

#include <gtest/gtest.h>

#include <set>
#include <thread>
#include <vector>

namespace planecast {
namespace {

class Pool {
 public:
  explicit Pool(std::uint32_t slots)
      : arena_(std::move(Arena::map(std::size_t{1} << 16U).value())) {
    EXPECT_EQ(pool_.init(arena_, slots), Status::kOk);
  }
  SlotPool* operator->() { return &pool_; }

 private:
  Arena arena_;
  SlotPool pool_;
};

TEST(SlotPool, GivesEachHandleOnceThenDropsAndCounts) {
  Pool pool(3);
  std::set<std::uint32_t> handles;
  for (int i = 0; i < 3; ++i) handles.insert(pool->claim().value());
  EXPECT_EQ(handles, (std::set<std::uint32_t>{0, 1, 2}));
  EXPECT_FALSE(pool->claim().has_value());
  EXPECT_FALSE(pool->claim().has_value());
  EXPECT_EQ(pool->offered(), 5U);
  EXPECT_EQ(pool->dropped(), 2U);
}

TEST(SlotPool, ReleasedHandleIsClaimedAgain) {
  Pool pool(2);
  ASSERT_EQ(pool->claim(), 0U);
  ASSERT_EQ(pool->claim(), 1U);
  EXPECT_TRUE(pool->release(1));
  EXPECT_EQ(pool->claim(), 1U);
  EXPECT_FALSE(pool->claim().has_value());
}

TEST(SlotPool, SecondReleaseAndForeignHandleChangeNothing) {
  Pool pool(2);
  ASSERT_EQ(pool->claim(), 0U);
  EXPECT_TRUE(pool->release(0));
  EXPECT_FALSE(pool->release(0));
  EXPECT_FALSE(pool->release(1));
  EXPECT_FALSE(pool->release(2));
  EXPECT_FALSE(pool->release(0xFFFFFFFFU));
  EXPECT_TRUE(pool->claim().has_value());
  EXPECT_TRUE(pool->claim().has_value());
  EXPECT_FALSE(pool->claim().has_value());
}

TEST(SlotPool, UnclaimedFrameCountsAsDroppedAndFreesItsSlot) {
  Pool pool(1);
  ASSERT_EQ(pool->claim(), 0U);
  pool->unclaim(0);
  pool->unclaim(0);
  EXPECT_EQ(pool->dropped(), 1U);
  EXPECT_EQ(pool->claim(), 0U);
  EXPECT_FALSE(pool->claim().has_value());
}

TEST(SlotPool, RefusesNoSlotsAndTooMany) {
  Arena arena = Arena::measuring();
  SlotPool pool;
  EXPECT_EQ(pool.init(arena, 0), Status::kBadConfig);
  EXPECT_EQ(pool.init(arena, SlotPool::kMaxSlots + 1), Status::kBadConfig);
}

// The claimer owns a plain counter per slot while it holds it: a slot held twice is a data race
// (ThreadSanitizer) and a wrong sum (everywhere).
TEST(SlotPool, HandlesGoRoundBetweenTwoThreadsOneOwnerAtATime) {
  constexpr std::uint32_t kFrames = 200'000;
  Pool pool(4);
  Arena arena = std::move(Arena::map(4096).value());
  SpscRing forward;
  ASSERT_EQ(forward.init(arena, 4), Status::kOk);
  std::vector<std::uint64_t> uses(4, 0);
  std::thread last([&] {
    std::uint32_t handle = 0;
    while (forward.pop_wait(handle)) {
      ++uses[handle];
      EXPECT_TRUE(pool->release(handle));
    }
  });
  for (std::uint32_t i = 0; i < kFrames; ++i) {
    const auto handle = pool->claim_wait();
    ASSERT_TRUE(handle.has_value());
    ++uses[*handle];
    ASSERT_TRUE(forward.try_push(*handle));
  }
  forward.close();
  last.join();
  EXPECT_EQ(uses[0] + uses[1] + uses[2] + uses[3], 2ULL * kFrames);
  EXPECT_EQ(pool->dropped(), 0U);
}

TEST(SlotPool, CloseEndsAWaitingClaimAndCountsItDropped) {
  Pool pool(1);
  ASSERT_TRUE(pool->claim().has_value());
  std::thread closer([&] { pool->close(); });
  EXPECT_FALSE(pool->claim_wait().has_value());
  closer.join();
  EXPECT_EQ(pool->dropped(), 1U);
  pool->reopen();
  EXPECT_TRUE(pool->release(0));
  EXPECT_TRUE(pool->claim_wait().has_value());
}

}  // namespace
}  // namespace planecast
