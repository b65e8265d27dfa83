// Keys of cells and their order.
#include "core/wire/z_order.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace planecast {
namespace {

bool before(const ZKey& a, const ZKey& b) {
  return a.high != b.high ? a.high < b.high : a.low < b.low;
}

TEST(ZOrder, KeysGiveBackTheirCells) {
  std::mt19937 random(1);
  for (int i = 0; i < 2000; ++i) {
    const auto x = static_cast<std::uint32_t>(random() >> (i % 32));
    const auto y = static_cast<std::uint32_t>(random() >> (i / 7 % 32));
    const auto z = static_cast<std::uint32_t>(random());
    const ZKey key = z_key(x, y, z, 5);
    EXPECT_EQ(z_cell(key), (std::array{x, y, z}));
    std::array<std::uint32_t, 3> cell{};
    for (unsigned level = 32; level-- > 0;)
      for (unsigned axis = 0; axis < 3; ++axis)
        cell[axis] = cell[axis] << 1U | (key.octant(level) >> axis & 1U);
    EXPECT_EQ(cell, (std::array{x, y, z}));
  }
}

TEST(ZOrder, DepthIsTheNumberOfLevelsThatDiffer) {
  EXPECT_EQ(z_depth(z_key(5, 6, 7, 0), z_key(5, 6, 7, 1)), 0U);
  EXPECT_EQ(z_depth(z_key(4, 6, 7, 0), z_key(5, 6, 7, 0)), 1U);
  EXPECT_EQ(z_depth(z_key(0, 0, 1U << 20U, 0), z_key(0, 0, 0, 0)), 21U);
  EXPECT_EQ(z_depth(z_key(1U << 21U, 0, 0, 0), z_key(0, 0, 0, 0)), 22U);
  EXPECT_EQ(z_depth(z_key(0, 1U << 31U, 0, 0), z_key(0, 0, 0, 0)), 32U);
}

TEST(ZOrder, SortsAsStdSortDoesAndKeepsEqualCellsInOrder) {
  std::mt19937 random(2);
  for (const unsigned shift : {0U, 12U, 29U}) {
    std::vector<ZKey> keys, spare(3000);
    for (std::uint32_t i = 0; i < spare.size(); ++i) {
      const auto next = [&] { return static_cast<std::uint32_t>(random() >> shift); };
      const std::uint32_t x = next(), y = next(), z = next();
      keys.push_back(z_key(x, y, z, i));
    }
    std::vector<ZKey> expected = keys;
    std::stable_sort(expected.begin(), expected.end(), before);
    sort_z_keys(keys, spare);
    for (std::size_t i = 0; i < keys.size(); ++i) {
      ASSERT_TRUE(keys[i].same_cell(expected[i]));
      ASSERT_EQ(keys[i].point, expected[i].point);
    }
  }
}

}  // namespace
}  // namespace planecast
