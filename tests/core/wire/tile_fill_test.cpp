// A tile that ended early says its true height, whatever bytes follow its head.
#include "core/wire/tile_fill.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "core/base/random.hpp"
#include "core/wire/range_decoder.hpp"

namespace planecast {
namespace {

TEST(TileFill, RecodedHeightIsReadBackAndNothingElseChanges) {
  Pcg32 random(5);
  CameraModel camera;
  camera.width = 640;
  camera.height = 480;
  const int xb = position_bits(blocks_wide(camera)), yb = position_bits(blocks_high(camera));
  for (int run = 0; run < 30000; ++run) {
    const std::uint32_t said = 2 + random.below(50), rows = 1 + random.below(said - 1);
    // Bytes of zeros are common, at the end too.
    std::vector<std::uint32_t> bytes(random.below(24));
    for (std::uint32_t& b : bytes) b = random.below(2) != 0 ? 0 : random.below(256);
    std::vector<std::uint8_t> out(64, 0xcd);
    RangeEncoder encoder(out);
    encoder.raw(kModelled, 1);
    code_rect(encoder, camera, {7, random.below(9), 20, said});
    for (const std::uint32_t b : bytes) encoder.raw(b, 8);
    const std::size_t used = encoder.finish();
    const std::size_t now = recode_height(out, used, camera, said, rows);

    RangeDecoder decoder({out.data(), now});
    ASSERT_EQ(decoder.raw(1), kModelled);
    ASSERT_EQ(decoder.raw(xb), 7U);
    decoder.raw(yb);
    ASSERT_EQ(decoder.raw(std::min(xb, 8)), 19U);
    ASSERT_EQ(decoder.raw(std::min(yb, 8)), rows - 1);
    for (const std::uint32_t b : bytes) ASSERT_EQ(decoder.raw(8), b) << run;
    ASSERT_FALSE(decoder.truncated()) << run;
    ASSERT_FALSE(decoder.trailing()) << run;
  }
}

}  // namespace
}  // namespace planecast
