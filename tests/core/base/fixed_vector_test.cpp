#include "core/base/fixed_vector.hpp"

#include <gtest/gtest.h>

#include <array>
#include <numeric>
#include <utility>

namespace planecast {
namespace {

TEST(FixedVector, RefusesToGrowPastItsMemory) {
  std::array<int, 3> memory{};
  FixedVector<int> vector{std::span<int>(memory)};
  EXPECT_TRUE(vector.push_back(1));
  EXPECT_TRUE(vector.push_back(2));
  EXPECT_TRUE(vector.push_back(3));
  EXPECT_TRUE(vector.full());
  EXPECT_FALSE(vector.push_back(4));
  EXPECT_EQ(vector.size(), 3U);
  EXPECT_EQ(vector.back(), 3);
  EXPECT_EQ(std::accumulate(vector.begin(), vector.end(), 0), 6);
}

TEST(FixedVector, AppendsAllOrNothing) {
  std::array<int, 4> memory{};
  FixedVector<int> vector{std::span<int>(memory)};
  const std::array<int, 3> values{5, 6, 7};
  EXPECT_TRUE(vector.append(values));
  EXPECT_FALSE(vector.append(values));
  EXPECT_EQ(vector.size(), 3U);
  EXPECT_TRUE(vector.append(std::span(values).first(1)));
  EXPECT_EQ(vector[3], 5);
}

TEST(FixedVector, ResizeInitialisesOnlyWhatIsNew) {
  std::array<int, 4> memory{9, 9, 9, 9};
  FixedVector<int> vector{std::span<int>(memory)};
  ASSERT_TRUE(vector.push_back(1));
  EXPECT_TRUE(vector.resize(3));
  EXPECT_EQ(vector[0], 1);
  EXPECT_EQ(vector[2], 0);
  EXPECT_EQ(memory[3], 9);
  EXPECT_FALSE(vector.resize(5));
  EXPECT_EQ(vector.size(), 3U);
  EXPECT_TRUE(vector.resize(1));
  EXPECT_EQ(vector.view().size(), 1U);
}

TEST(FixedVector, WithoutMemoryHoldsNothing) {
  FixedVector<int> vector;
  EXPECT_TRUE(vector.empty());
  EXPECT_TRUE(vector.full());
  EXPECT_FALSE(vector.push_back(1));
}

TEST(FixedVector, MoveLeavesTheSourceEmpty) {
  std::array<int, 2> memory{};
  FixedVector<int> vector{std::span<int>(memory)};
  ASSERT_TRUE(vector.push_back(4));
  FixedVector<int> moved = std::move(vector);
  EXPECT_EQ(moved.size(), 1U);
  EXPECT_EQ(vector.capacity(), 0U);  // NOLINT(bugprone-use-after-move): documented
  moved.pop_back();
  EXPECT_TRUE(moved.empty());
  EXPECT_TRUE(moved.push_back(8));
  moved.clear();
  EXPECT_EQ(moved.capacity(), 2U);
}

}  // namespace
}  // namespace planecast
