// The image codecs of the benchmark give back what they promise: every count, or one within the
// setting, and every hole.
#include "bench/baselines/depth_baselines.hpp"

#include <gtest/gtest.h>

#include "core/base/random.hpp"

namespace planecast::baselines {
namespace {

// A slanted wall on a stereo lattice with a step, noise, holes in runs and alone, and both ends of
// what 16 bits hold.
DepthImage wall() {
  DepthImage image{97, 61, {}};
  Pcg32 random(7);
  for (std::uint32_t v = 0; v < image.height; ++v) {
    for (std::uint32_t u = 0; u < image.width; ++u) {
      const std::uint32_t level = 100 + u / 2 + (v > 30 ? 60 : 0) + random.next() % 3;
      const bool hole = random.next() % 23 == 0 || (u > 40 && u < 52 && v < 20);
      image.depth.push_back(hole ? 0 : static_cast<std::uint16_t>(600000 / level));
    }
  }
  image.depth[5] = 65000;
  image.depth[6] = 130;
  return image;
}

// Largest difference in counts; fails where a hole and a reading were mixed up.
int largest_error(const DepthImage& a, const DepthImage& b) {
  EXPECT_EQ(a.width, b.width);
  EXPECT_EQ(a.height, b.height);
  if (a.depth.size() != b.depth.size()) return 1 << 20;
  int worst = 0;
  for (std::size_t i = 0; i < a.depth.size(); ++i) {
    if ((a.depth[i] == 0) != (b.depth[i] == 0)) return 1 << 20;
    worst = std::max(worst, std::abs(int{a.depth[i]} - int{b.depth[i]}));
  }
  return worst;
}

TEST(DepthBaselines, EveryLosslessOneReturnsEveryCount) {
  std::vector<std::string> skipped;
  int lossless = 0;
  for (const auto& codec : depth_set(skipped)) {
    if (codec->setting() != "lossless") continue;
    ++lossless;
    const Bytes bytes = codec->encode(wall());
    EXPECT_EQ(largest_error(wall(), codec->decode(bytes)), 0) << codec->name();
    EXPECT_LT(bytes.size(), wall().depth.size() * 2) << codec->name();
  }
  EXPECT_GE(lossless, 3);  // RVL and PNG need no library that the product does not
  for (const std::string& peer : skipped) std::printf("skipped: %s\n", peer.c_str());
}

TEST(DepthBaselines, StepsKeepEveryReadingWithinHalfAStep) {
  for (const int step : {2, 5, 20, 100}) {
    const auto codec = z_step(step, rvl(0));
    const DepthImage decoded = codec->decode(codec->encode(wall()));
    EXPECT_LE(largest_error(wall(), decoded), (step + 1) / 2) << step;
  }
}

TEST(DepthBaselines, NearLosslessStaysWithinItsSettingAndKeepsHoles) {
  if (!charls_available()) GTEST_SKIP() << "CharLS: libcharls-dev is not installed";
  for (const int near : {1, 5, 50}) {
    const auto codec = charls_depth(near);
    EXPECT_LE(largest_error(wall(), codec->decode(codec->encode(wall()))), near);
  }
}

TEST(DepthBaselines, NearLosslessOnTheLatticeStaysWithinItsLevels) {
  if (!charls_available()) GTEST_SKIP() << "CharLS: libcharls-dev is not installed";
  std::vector<std::uint16_t> levels = wall().depth;
  std::sort(levels.begin(), levels.end());
  levels.erase(std::unique(levels.begin(), levels.end()), levels.end());
  const auto rank = [&](std::uint16_t d) {
    return static_cast<int>(std::lower_bound(levels.begin(), levels.end(), d) - levels.begin());
  };
  const auto codec = lattice_index(charls_depth(2));
  const DepthImage original = wall(), decoded = codec->decode(codec->encode(original));
  EXPECT_LT(largest_error(original, decoded), 1 << 20);
  for (std::size_t i = 0; i < original.depth.size(); ++i)
    ASSERT_LE(std::abs(rank(original.depth[i]) - rank(decoded.depth[i])), 2);
}

TEST(DepthBaselines, CutBytesAreRefused) {
  Bytes bytes = rvl(0)->encode(wall());
  bytes.resize(bytes.size() / 2);
  EXPECT_THROW((void)rvl(0)->decode(bytes), std::runtime_error);
}

}  // namespace
}  // namespace planecast::baselines
