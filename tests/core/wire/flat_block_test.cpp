// Flat blocks: what the encoder finds, the decoder foretells and steps to alike; the bound holds
// for every reading; a plane within the bound is found whatever its holes.
#include <gtest/gtest.h>

#include <cmath>

#include "core/wire/flat_fit.hpp"
#include "tests/core/wire/wire_bench.hpp"

namespace planecast {
namespace {

using test::Image;
using test::WireBench;

StreamConfig metres_stream(Pcg32& random, double bound_m) {
  StreamConfig config = test::random_config(random, 4);
  config.camera = test::random_camera(random, 64, 48, 1.5, false);
  config.camera.unit_pm = 1'000'000'000;
  config.lattice = {};
  config.tolerance = ToleranceKind::kMetres;
  config.tolerance_100nm = static_cast<std::uint32_t>(std::lround(bound_m * 1e7));
  config.drop_off_surface = false;
  return config;
}

Image plane_image(const CameraModel& camera, double base, double dx, double dy, double noise,
                  Pcg32& random) {
  Image out(camera.pixels());
  for (std::uint32_t v = 0, i = 0; v < camera.height; ++v) {
    for (std::uint32_t u = 0; u < camera.width; ++u, ++i) {
      const double z = base + dx * u + dy * v + noise * (2 * random.uniform() - 1);
      out[i] = static_cast<std::uint16_t>(std::lround(z));
    }
  }
  return out;
}

TEST(FlatBlock, PlanesWithNoiseOfHalfTheBoundNeedNoCorrection) {
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    SCOPED_TRACE(seed);
    Pcg32 random(seed);
    WireBench b(metres_stream(random, 0.020));
    Image image = plane_image(b.config.camera, 3000, test::between(random, -3, 3),
                              test::between(random, -3, 3), 5, random);
    if (seed % 3 == 0)
      for (std::uint16_t& d : image) d = random.below(9) == 0 ? std::uint16_t{0} : d;
    const auto packets = b.pack(image, kFileSliceBytes);
    EXPECT_EQ(b.report.corrections, 0U);
    const Image out = b.unpack_all(packets);
    for (std::size_t i = 0; i < image.size(); ++i) {
      ASSERT_EQ(image[i] == 0, out[i] == 0);
      ASSERT_LE(std::abs(int{image[i]} - int{out[i]}), 20);
    }
  }
}

TEST(FlatBlock, CostsLessThanAQuarterBitAPointOnANoisyPlane) {
  Pcg32 random(5);
  WireBench b(metres_stream(random, 0.020));
  const Image image = plane_image(b.config.camera, 3000, 1.5, -0.7, 8, random);
  (void)b.pack(image, kFileSliceBytes);
  EXPECT_LT(static_cast<double>(b.report.bytes) * 8, 0.25 * static_cast<double>(image.size()));
}

TEST(FlatBlock, TheFitLeadsToAPlaneWithinEveryWindow) {
  Pcg32 random(9);
  int found = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    FlatWindow window;
    const std::int32_t half = static_cast<std::int32_t>(random.below(20));
    const PlaneSteps steps(half);
    const double dx = test::between(random, -900, 900), dy = test::between(random, -900, 900);
    const double noise = test::between(random, 0, 1.2) * half;
    for (int i = 0; i < 64; ++i) {
      const double level = 4000 + (dx * (i % 8) + dy * (i / 8)) / 256;
      const auto own =
          static_cast<std::int32_t>(std::lround(level + noise * (2 * random.uniform() - 1)));
      const bool hole = random.below(5) == 0;
      window.own[i] = hole ? 0 : own;
      window.low[i] = hole ? -(1 << 28) : (own - half) * 256 - 128;
      window.high[i] = hole ? 1 << 28 : (own + half) * 256 + 127;
      window.readings += !hole;
    }
    const BlockPlane foretold{4000 * 256, static_cast<std::int32_t>(random.below(800)),
                              -static_cast<std::int32_t>(random.below(800))};
    FlatCode code;
    if (!fit_flat(window, foretold, steps, 65535, code)) continue;
    ++found;
    const BlockSurface plane = BlockPlane::clamped(foretold.middle + code.offset * steps.offset,
                                                   foretold.dx + code.dx * steps.slope,
                                                   foretold.dy + code.dy * steps.slope, 65535)
                                   .surface();
    for (std::uint32_t i = 0; i < 64; ++i) {
      if (window.own[i] == 0) continue;
      const std::int32_t level = (plane.at(i % 8, i / 8) + 128) >> 8;
      ASSERT_LE(std::abs(level - window.own[i]), half) << trial << " pixel " << i;
    }
  }
  EXPECT_GT(found, 1200);
}

TEST(FlatBlock, LosslessStreamsHaveNone) {
  Pcg32 random(3);
  StreamConfig config = metres_stream(random, 0.01);
  config.tolerance = ToleranceKind::kLossless;
  WireBench b(config);
  const Image image = plane_image(b.config.camera, 3000, 2, 1, 3, random);
  EXPECT_EQ(b.unpack_all(b.pack(image, kFileSliceBytes)), image);
}

}  // namespace
}  // namespace planecast
