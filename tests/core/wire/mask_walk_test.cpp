// Contexts of the hole mask, eight pixels at a time: as the pixels around say them one by one.
#include "core/wire/mask_walk.hpp"

#include <gtest/gtest.h>

#include "core/base/random.hpp"

namespace planecast {
namespace {

// docs/wire-format.md, "Pixels": left, above, above left, above right, two left, two above, above
// two right and two left.
std::uint32_t context_at(const PixelRow& here, const PixelRow& above, const PixelRow& above2,
                         std::size_t at) {
  const std::uint16_t around[8] = {here.level[at - 1],  above.level[at],    above.level[at - 1],
                                   above.level[at + 1], here.level[at - 2], above2.level[at],
                                   above.level[at + 2], above.level[at - 2]};
  std::uint32_t context = 0;
  for (unsigned i = 0; i < 8; ++i) {
    if (around[i] != 0) context |= 1U << i;
  }
  return context;
}

TEST(MaskWalk, SaysTheContextOfEveryPixelBeforeItIsKnown) {
  Pcg32 random(1);
  PixelRow rows[3];
  for (int trial = 0; trial < 300; ++trial) {
    PixelRow &here = rows[trial % 3], &above = rows[(trial + 2) % 3],
             &above2 = rows[(trial + 1) % 3];
    const std::uint32_t most = 1 + random.below(4);
    for (std::uint32_t x = 0; x + 8 <= 64; x += 8) {
      const std::size_t first = x + PixelRow::kBorder;
      for (std::size_t at = first; at < first + 8; ++at) here.level[at] = 7;  // not looked at
      MaskWalk mask(here, above, above2, first);
      for (std::size_t at = first; at < first + 8; ++at) {
        ASSERT_EQ(mask.context(), context_at(here, above, above2, at)) << trial << " at " << at;
        here.level[at] = static_cast<std::uint16_t>(random.below(most) * 9000);
        mask.step(here.level[at] != 0);
      }
    }
  }
}

}  // namespace
}  // namespace planecast
