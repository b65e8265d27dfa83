// Four lanes at once against one by one.
#include "core/base/lanes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace planecast {
namespace {

TEST(Lanes, FourAtOnceGiveWhatOneByOneGives) {
  const float a[4] = {1.5F, -2.0F, 0.0F, 7.25F}, b[4] = {-1.0F, -3.0F, 0.5F, 9.0F};
  const std::uint16_t counts[4] = {0, 1, 40000, 65535};
  const Float4 low = min4(load4(a), load4(b)), high = max4(load4(a), load4(b));
  const Float4 size = abs4(load4(a)), depth = load4(counts);
  const Float4 kept = keep4(load4(a) > load4(b), load4(a));
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(low[i], std::min(a[i], b[i]));
    EXPECT_EQ(high[i], std::max(a[i], b[i]));
    EXPECT_EQ(size[i], std::abs(a[i]));
    EXPECT_EQ(depth[i], static_cast<float>(counts[i]));
    EXPECT_EQ(kept[i], a[i] > b[i] ? a[i] : 0.0F);
  }
  EXPECT_EQ(sum4(load4(a)), 6.75F);
}

}  // namespace
}  // namespace planecast
