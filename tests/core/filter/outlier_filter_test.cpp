// The outlier filter flags what stands alone, keeps edges and holes, and survives tiny frames.
#include "core/filter/outlier_filter.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace planecast {
namespace {

struct Flagged {
  std::vector<std::uint8_t> flags;
  OutlierCounts counts;
  Status status = Status::kOk;
};

Flagged filtered(const std::vector<std::uint16_t>& depth, std::uint32_t width,
                 std::uint32_t height) {
  Result<Arena> arena = Arena::map(4U << 20U);
  OutlierFilter filter;
  filter.layout(*arena, 128, 128);
  Flagged out;
  out.flags.assign(depth.size(), 7);
  out.status = filter.process(depth, width, height, {}, out.flags, out.counts);
  return out;
}

TEST(OutlierFilter, FlagsASpikeAndNothingElseOnASlope) {
  std::vector<std::uint16_t> depth(64 * 48);
  for (std::size_t i = 0; i < depth.size(); ++i) {
    depth[i] = static_cast<std::uint16_t>(2000 + i % 64 + (i * 7919) % 3);
  }
  depth[20 * 64 + 30] = 2900;
  const Flagged out = filtered(depth, 64, 48);
  EXPECT_EQ(out.status, Status::kOk);
  EXPECT_EQ(out.flags[20 * 64 + 30], 1);
  EXPECT_EQ(out.counts.outliers, 1U);
  EXPECT_EQ(out.counts.readings, 64U * 48U);
}

TEST(OutlierFilter, KeepsBothSidesOfAStraightEdge) {
  std::vector<std::uint16_t> depth(64 * 48);
  for (std::size_t i = 0; i < depth.size(); ++i) depth[i] = i % 64 < 31 ? 1000 : 3000;
  const Flagged out = filtered(depth, 64, 48);
  // Where the edge meets the image border, the diagonals have lost their own-side neighbours.
  EXPECT_EQ(std::count(out.flags.begin() + 64, out.flags.end() - 64, 1), 0);
  EXPECT_LE(out.counts.outliers, 4U);
}

TEST(OutlierFilter, CallsAReadingAmongHolesIsolated) {
  std::vector<std::uint16_t> depth(32 * 32, 0);
  for (std::size_t i = 0; i < 10 * 32; ++i) depth[i] = 1500;
  depth[20 * 32 + 20] = 1500;
  const Flagged out = filtered(depth, 32, 32);
  EXPECT_EQ(out.counts.isolated, 1U);
  EXPECT_EQ(out.counts.outliers, 1U);
  EXPECT_EQ(out.flags[20 * 32 + 20], 1);
  std::vector<std::uint16_t> kept = depth;
  EXPECT_EQ(drop_flagged(kept, out.flags), 1U);
  EXPECT_EQ(kept[20 * 32 + 20], 0);
}

TEST(OutlierFilter, TakesAnyShapeAndRefusesWrongSizes) {
  for (const auto& [w, h] : {std::pair{1U, 1U}, {100U, 1U}, {1U, 100U}, {7U, 5U}, {0U, 0U}}) {
    const std::vector<std::uint16_t> depth(w * h, 1000);
    const Flagged out = filtered(depth, w, h);
    EXPECT_EQ(out.status, Status::kOk) << w << " x " << h;
    EXPECT_EQ(out.counts.readings, w * h);
    EXPECT_EQ(out.counts.isolated, w * h == 1 ? 1U : 0U);
    EXPECT_EQ(std::count(out.flags.begin(), out.flags.end(), 7), 0);
  }
  EXPECT_EQ(filtered(std::vector<std::uint16_t>(200 * 4), 200, 4).status, Status::kFrameTooLarge);
  EXPECT_EQ(filtered(std::vector<std::uint16_t>(10), 3, 3).status, Status::kWrongSize);
  EXPECT_EQ(filtered(std::vector<std::uint16_t>(64, 0), 8, 8).counts.outliers, 0U);
}

TEST(RangeGate, MakesHolesOfWhatLiesOutsideAndCountsIt) {
  std::vector<std::uint16_t> depth = {0, 199, 200, 5000, 10000, 10001, 65535};
  EXPECT_EQ(apply_range_gate(depth, 200, 10000), 3U);
  EXPECT_EQ(depth, (std::vector<std::uint16_t>{0, 0, 200, 5000, 10000, 0, 0}));
}

}  // namespace
}  // namespace planecast
