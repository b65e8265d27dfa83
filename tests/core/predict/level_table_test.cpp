// Levels against their definition, for plausible, odd and hostile lattices.
#include "core/predict/level_table.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include "tests/core/model/random_config.hpp"

namespace planecast {
namespace {

struct Levels {
  Arena arena = std::move(*Arena::map(std::size_t{1} << 20U));
  LevelTable table;
  Status status;
  explicit Levels(const Lattice& lattice) {
    table.layout(arena);
    status = table.build(lattice);
  }
};

// Every count up to sqrt(C), then the lattice's own, until one leaves 16 bits.
std::vector<std::uint32_t> expected_levels(const Lattice& lattice) {
  std::vector<std::uint32_t> out{0};
  if (!lattice.present()) {
    for (std::uint32_t d = 1; d < 65536; ++d) out.push_back(d);
    return out;
  }
  auto dense = static_cast<std::uint64_t>(std::sqrt(lattice.c_q8 >> 8U));
  while (dense * dense > (lattice.c_q8 >> 8U)) --dense;
  while ((dense + 1) * (dense + 1) <= (lattice.c_q8 >> 8U)) ++dense;
  for (std::uint32_t d = 1; d <= dense; ++d) out.push_back(d);
  for (std::uint64_t k = (lattice.c_q8 >> 8U) / dense + 1; k >= 1; --k) {
    const std::uint64_t depth = lattice_depth(lattice, k);
    if (depth > 65535) break;
    if (depth > out.back()) out.push_back(static_cast<std::uint32_t>(depth));
  }
  return out;
}

void expect_as_defined(const Lattice& lattice) {
  const Levels levels(lattice);
  ASSERT_EQ(levels.status, Status::kOk);
  const auto expected = expected_levels(lattice);
  ASSERT_EQ(levels.table.count(), expected.size()) << lattice.c_q8;
  for (std::uint32_t l = 0; l < expected.size(); ++l) ASSERT_EQ(levels.table.depth(l), expected[l]);
  for (std::uint32_t d = 1; d < 65536; ++d) {
    // Nearest, the farther one of two that are equally near.
    const auto above = std::lower_bound(expected.begin() + 1, expected.end(), d);
    auto best = static_cast<std::uint32_t>(above - expected.begin());
    if (best == expected.size() || (best > 1 && d - expected[best - 1] < expected[best] - d)) {
      --best;
    }
    ASSERT_EQ(levels.table.nearest(static_cast<std::uint16_t>(d)), best) << d;
  }
  EXPECT_EQ(levels.table.nearest(0), 0);
}

TEST(LevelTable, WithoutALatticeEveryCountIsItsOwnLevel) {
  const Levels levels(Lattice{});
  ASSERT_EQ(levels.table.count(), 65536U);
  for (std::uint32_t d = 0; d < 65536; ++d) {
    ASSERT_EQ(levels.table.depth(d), d);
    ASSERT_EQ(levels.table.nearest(static_cast<std::uint16_t>(d)), d);
  }
}

TEST(LevelTable, LevelsAndNearestLevelsAreAsDefined) {
  Pcg32 random(21);
  expect_as_defined({kMinLatticeCQ8, 0, false});
  expect_as_defined({0xffffffffU, 65535, true});
  expect_as_defined({0xffffffffU, 0, false});
  expect_as_defined({350'000U * 256U, 0, true});
  for (int i = 0; i < 12; ++i) {
    Lattice lattice = test::random_lattice(random);
    if (!lattice.present()) lattice.c_q8 = kMinLatticeCQ8 + random.below(100'000);
    expect_as_defined(lattice);
  }
}

TEST(LevelTable, ALatticeBelowTwoCountsIsRefused) {
  EXPECT_EQ(Levels({kMinLatticeCQ8 - 1, 0, false}).status, Status::kFieldRange);
}

TEST(LevelTable, LatticeDepthIsTheRoundedOrCutQuotient) {
  Pcg32 random(22);
  for (int i = 0; i < 20000; ++i) {
    Lattice lattice = test::random_lattice(random);
    lattice.c_q8 = std::max(lattice.c_q8, kMinLatticeCQ8);
    const std::uint64_t k = 1 + random.below(4000);
    const long double exact = static_cast<long double>(lattice.c_q8) / 256 /
                              (static_cast<long double>(k) + lattice.offset_q16 / 65536.0L);
    const auto depth = static_cast<long double>(lattice_depth(lattice, k));
    const long double off = depth - exact;
    EXPECT_LE(off, lattice.truncated ? 0.0L : 0.5L);
    EXPECT_GT(off, (lattice.truncated ? -1.0L : -0.5L) - 1.0L / 256);
  }
}

TEST(LevelTable, PositionOfAnInverseDepthFallsAsItGrowsAndStaysInTheTable) {
  Pcg32 random(23);
  for (int i = 0; i < 20; ++i) {
    const Levels levels(test::random_lattice(random));
    ASSERT_EQ(levels.status, Status::kOk);
    std::int32_t last = static_cast<std::int32_t>(levels.table.count() - 1) * 256;
    EXPECT_LE(levels.table.level_q8(-5), last);
    for (std::int64_t iv = -2; iv < (std::int64_t{1} << 36); iv += 1 + iv / 500) {
      const std::int32_t at = levels.table.level_q8(iv);
      // Where counts give way to the lattice, one level's width is unsteady.
      EXPECT_LE(at, last + 256) << iv;
      EXPECT_GE(at, 256);
      last = std::min(last, at);
    }
    EXPECT_EQ(levels.table.level_q8(std::int64_t{1} << 36), 256);
  }
}

TEST(LevelTable, PositionOfALevelsOwnInverseDepthIsThatLevel) {
  for (const Lattice lattice :
       {Lattice{}, Lattice{350'000U * 256U, 0, false}, Lattice{1'000'000U * 256U, 30000, true}}) {
    const Levels levels(lattice);
    for (std::uint32_t l = 20; l < levels.table.count(); l += 7) {
      const auto iv = static_cast<std::int64_t>(0x1p31 / levels.table.depth(l));
      const std::int32_t at = levels.table.level_q8(iv);
      // Counts are whole, so near sqrt(C), where two lattice steps are one count, it is 1.5 off.
      EXPECT_NEAR(at / 256.0, l, 2.6) << levels.table.depth(l);
    }
  }
}

}  // namespace
}  // namespace planecast
