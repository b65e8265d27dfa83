#include "core/base/arena.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "core/base/random.hpp"

namespace planecast {
namespace {

std::uintptr_t address(const void* pointer) {
  return reinterpret_cast<std::uintptr_t>(pointer);
}

struct Layout {
  std::span<std::uint8_t> bytes;
  std::span<double> doubles;
  std::span<std::uint16_t> shorts;
};

Layout lay_out(Arena& arena) {
  return {arena.take<std::uint8_t>(13), arena.take<double>(7, 8), arena.take<std::uint16_t>(5, 2)};
}

TEST(Arena, MeasuringNeedsExactlyWhatTheCarveUses) {
  Arena measuring = Arena::measuring();
  lay_out(measuring);
  EXPECT_EQ(measuring.bytes_needed(), 13U + 3U + 56U + 10U);
  EXPECT_FALSE(measuring.failed());

  Result<Arena> exact = Arena::map(measuring.bytes_needed());
  ASSERT_TRUE(exact.ok());
  const Layout layout = lay_out(*exact);
  EXPECT_FALSE(exact->failed());
  EXPECT_EQ(exact->bytes_used(), measuring.bytes_needed());
  EXPECT_EQ(layout.doubles.size(), 7U);
}

TEST(Arena, OneByteLessThanMeasuredFails) {
  Arena measuring = Arena::measuring();
  lay_out(measuring);
  Result<Arena> small = Arena::map(measuring.bytes_needed() - 1);
  ASSERT_TRUE(small.ok());
  const Layout layout = lay_out(*small);
  EXPECT_TRUE(layout.shorts.empty());
  EXPECT_TRUE(small->failed());
  EXPECT_EQ(small->bytes_needed(), measuring.bytes_needed());
}

TEST(Arena, RandomLayoutsMeasureAndCarveAlike) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const auto build = [seed](Arena& arena) {
      Pcg32 random(seed);
      std::uint64_t used = 0;
      for (std::uint32_t i = 0, n = 1 + random.below(20); i < n; ++i) {
        const std::size_t align = std::size_t{1} << random.below(7);
        used += arena.take<std::uint32_t>(random.below(100), align).size();
      }
      return used;
    };
    Arena measuring = Arena::measuring();
    EXPECT_EQ(build(measuring), 0U);
    Result<Arena> real = Arena::map(measuring.bytes_needed());
    ASSERT_TRUE(real.ok());
    build(*real);
    EXPECT_FALSE(real->failed()) << "seed " << seed;
    EXPECT_EQ(real->bytes_used(), measuring.bytes_needed()) << "seed " << seed;
  }
}

TEST(Arena, SpansAreAlignedZeroedAndApart) {
  Result<Arena> arena = Arena::map(4096);
  ASSERT_TRUE(arena.ok());
  const auto first = arena->take<std::uint8_t>(1);
  const auto second = arena->take<std::uint64_t>(4);
  ASSERT_EQ(second.size(), 4U);
  EXPECT_EQ(address(second.data()) % kCacheLineBytes, 0U);
  EXPECT_EQ(address(second.data()), address(first.data()) + 64);
  for (const std::uint64_t value : second) EXPECT_EQ(value, 0U);
}

TEST(Arena, GivenBlockIsUsedAndValuesAreInitialised) {
  alignas(64) std::array<std::byte, 256> block;
  block.fill(std::byte{0xA5});
  Result<Arena> arena = Arena::over(block);
  ASSERT_TRUE(arena.ok());
  const auto taken = arena->take<std::uint32_t>(4);
  ASSERT_EQ(taken.size(), 4U);
  EXPECT_EQ(address(taken.data()), address(block.data()));
  for (const std::uint32_t value : taken) EXPECT_EQ(value, 0U);
}

TEST(Arena, RefusesAMisalignedBlockAndNamesTheMend) {
  alignas(64) std::array<std::byte, 256> block;
  const Result<Arena> arena = Arena::over(std::span(block).subspan(8));
  ASSERT_FALSE(arena.ok());
  EXPECT_EQ(arena.error().status, Status::kBadConfig);
  EXPECT_NE(arena.error().message.find("64"), std::string::npos);
}

TEST(Arena, FailureSticksEvenForATakeThatWouldFit) {
  Result<Arena> arena = Arena::map(128);
  ASSERT_TRUE(arena.ok());
  EXPECT_TRUE(arena->take<std::uint8_t>(129).empty());
  EXPECT_TRUE(arena->take<std::uint8_t>(1).empty());
  EXPECT_TRUE(arena->failed());
  EXPECT_EQ(arena->bytes_used(), 0U);
}

TEST(Arena, SealedArenaRefusesEveryTake) {
  Result<Arena> arena = Arena::map(1024);
  ASSERT_TRUE(arena.ok());
  EXPECT_EQ(arena->take<std::uint8_t>(8).size(), 8U);
  arena->seal();
  EXPECT_FALSE(arena->failed());
  EXPECT_TRUE(arena->take<std::uint8_t>(1).empty());
  EXPECT_TRUE(arena->failed());
  EXPECT_EQ(arena->bytes_used(), 8U);
}

TEST(Arena, CountsTimesSizeThatOverflowFail) {
  constexpr std::size_t kMost = std::numeric_limits<std::size_t>::max();
  for (const std::size_t n : {kMost, kMost / 8, kMost / 8 + 1, kMost / 8 - 7}) {
    Arena arena = Arena::measuring();
    (void)arena.take<std::uint8_t>(128);
    (void)arena.take<std::uint64_t>(n);
    EXPECT_TRUE(arena.failed()) << n;
  }
}

TEST(Arena, BadAlignmentFails) {
  for (const std::size_t align : {std::size_t{3}, std::size_t{128}}) {
    Result<Arena> arena = Arena::map(1024);
    ASSERT_TRUE(arena.ok());
    EXPECT_TRUE(arena->take<std::uint8_t>(1, align).empty());
    EXPECT_TRUE(arena->failed());
  }
}

TEST(Arena, TakingNothingIsNoFailure) {
  Arena arena;
  EXPECT_TRUE(arena.take<int>(0).empty());
  EXPECT_FALSE(arena.failed());
  EXPECT_TRUE(arena.take<int>(1).empty());
  EXPECT_TRUE(arena.failed());
}

TEST(Arena, MoveKeepsTheMemory) {
  Result<Arena> mapped = Arena::map(256);
  ASSERT_TRUE(mapped.ok());
  const auto taken = mapped->take<int>(4);
  taken[3] = 7;
  Arena moved = std::move(*mapped);
  Arena assigned;
  assigned = std::move(moved);
  EXPECT_EQ(taken[3], 7);
  EXPECT_EQ(assigned.bytes_used(), 16U);
  EXPECT_EQ(assigned.capacity(), 256U);
  EXPECT_EQ(moved.capacity(), 0U);  // NOLINT(bugprone-use-after-move): emptied, as documented
}

TEST(Arena, WishesOfLockAndHugePagesNeverFailTheMapping) {
  Result<Arena> arena = Arena::map(3U << 20U, {.lock = true, .huge_pages = true});
  ASSERT_TRUE(arena.ok());
  EXPECT_EQ(arena->capacity(), 3U << 20U);
  const auto all = arena->take<std::uint8_t>(3U << 20U);
  ASSERT_FALSE(all.empty());
  all.back() = 1;
}

TEST(Arena, LockBeyondTheLimitIsAFlag) {
  // More than RLIMIT_MEMLOCK allows an ordinary user; root may lock it, then nothing is refused.
  Result<Arena> arena = Arena::map(64U << 20U, {.lock = true});
  ASSERT_TRUE(arena.ok());
  EXPECT_EQ(arena->take<std::uint8_t>(64U << 20U).size(), 64U << 20U);
}

TEST(Arena, ImpossibleMappingIsAnErrorWithItsSize) {
  for (const bool huge_pages : {false, true}) {
    const std::size_t bytes = std::numeric_limits<std::size_t>::max() - 4096;
    const Result<Arena> arena = Arena::map(bytes, {.huge_pages = huge_pages});
    ASSERT_FALSE(arena.ok());
    EXPECT_EQ(arena.error().status, Status::kOutOfArena);
    EXPECT_NE(arena.error().message.find(std::to_string(bytes)), std::string::npos);
  }
}

}  // namespace
}  // namespace planecast
