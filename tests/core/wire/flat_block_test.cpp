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

// A window of readings on a tilted plane around `level`, some of them holes.
FlatWindow random_window(Pcg32& random, std::int32_t level, std::int32_t half) {
  FlatWindow window;
  const double dx = test::between(random, -900, 900), dy = test::between(random, -900, 900);
  const double noise = test::between(random, 0, 1.2) * half;
  const std::uint32_t holes = random.below(2) * 5;
  for (int i = 0; i < 64; ++i) {
    const double at = level + (dx * (i % 8) + dy * (i / 8)) / 256;
    const auto own =
        static_cast<std::int32_t>(std::lround(at + noise * (2 * random.uniform() - 1)));
    const bool hole = holes != 0 && random.below(holes) == 0;
    window.low[i] = static_cast<std::uint16_t>(hole ? 0 : own - half);
    window.high[i] = static_cast<std::uint16_t>(hole ? 0 : own + half);
  }
  window.prepare();
  return window;
}

TEST(FlatBlock, TheFitLeadsToAPlaneWithinEveryWindow) {
  Pcg32 random(9);
  int found = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    const auto half = static_cast<std::int32_t>(random.below(20));
    const PlaneSteps steps(half);
    const std::int32_t level = trial % 3 == 0 ? 40000 : 4000;  // beyond 15 bits as well
    FlatWindow window = random_window(random, level, half);
    const BlockPlane foretold{level * 256, static_cast<std::int32_t>(random.below(800)),
                              -static_cast<std::int32_t>(random.below(800))};
    FlatCode code;
    if (!fit_flat(window, foretold, steps, 65535, code)) continue;
    ++found;
    const BlockSurface plane = BlockPlane::clamped(foretold.middle + code.offset * steps.offset,
                                                   foretold.dx + code.dx * steps.slope,
                                                   foretold.dy + code.dy * steps.slope, 65535)
                                   .surface();
    for (std::uint32_t i = 0; i < 64; ++i) {
      if (window.high[i] == 0) continue;
      const std::int32_t at = (plane.at(i % 8, i / 8) + 128) >> 8;
      ASSERT_TRUE(at >= window.low[i] && at <= window.high[i]) << trial << " pixel " << i;
    }
  }
  EXPECT_GT(found, 1200);
}

// A foretold plane that is only just allowed is left for the middle of what is allowed.
TEST(FlatBlock, ThePlaneLiesInTheMiddleOfItsWindows) {
  for (const std::int32_t level : {4000, 40000}) {
    for (std::int32_t half = 1; half < 20; ++half) {
      const PlaneSteps steps(half);
      FlatWindow window;
      for (int i = 0; i < 64; ++i) {
        window.low[i] = static_cast<std::uint16_t>(level - half);
        window.high[i] = static_cast<std::uint16_t>(level + half);
      }
      window.prepare();
      for (std::int32_t off = -half; off <= half; ++off) {
        const BlockPlane foretold{(level + off) * 256, 0, 0};
        FlatCode code;
        ASSERT_TRUE(fit_flat(window, foretold, steps, 65535, code));
        EXPECT_EQ(code.dx, 0);
        const std::int32_t from = foretold.middle + code.offset * steps.offset - level * 256;
        EXPECT_LE(std::abs(from), (2 * half + 1) * 256 / 5 + 1) << half << " " << off;
      }
    }
  }
}

TEST(FlatBlock, EightLanesOfSixteenBitsFindWhatWholeNumbersFind) {
  Pcg32 random(10);
  int narrow = 0, found = 0;
  for (int trial = 0; trial < 4000; ++trial) {
    const auto half = static_cast<std::int32_t>(random.below(30));
    FlatWindow window = random_window(random, 3000, half);
    const BlockPlane foretold{(3000 + static_cast<std::int32_t>(random.below(60)) - 30) * 256,
                              static_cast<std::int32_t>(random.below(2000)) - 1000,
                              static_cast<std::int32_t>(random.below(2000)) - 1000};
    narrow += window.narrow;
    FlatCode lanes, numbers;
    const bool fits = fit_flat(window, foretold, PlaneSteps(half), 65535, lanes);
    window.narrow = false;
    ASSERT_EQ(fit_flat(window, foretold, PlaneSteps(half), 65535, numbers), fits) << trial;
    if (!fits) continue;
    ++found;
    ASSERT_EQ(lanes.offset, numbers.offset);
    ASSERT_EQ(lanes.dx, numbers.dx);
    ASSERT_EQ(lanes.dy, numbers.dy);
  }
  EXPECT_GT(narrow, 3000);
  EXPECT_GT(found, 1200);
}

TEST(FlatBlock, AWindowIsWhatTheTableSaysOfEachReading) {
  Pcg32 random(11);
  std::vector<LevelWindow> table(65536);
  for (std::uint32_t d = 1; d < 65536; ++d) {
    table[d] = {static_cast<std::uint16_t>(1 + d / 3), static_cast<std::uint16_t>(1 + d / 3 + 7)};
  }
  for (int trial = 0; trial < 200; ++trial) {
    const std::uint32_t columns = trial < 100 ? 8 : 1 + random.below(8);
    const std::uint32_t rows = trial < 100 ? 8 : 1 + random.below(8);
    std::vector<std::uint16_t> depth(11 * 8);
    for (std::uint16_t& d : depth)
      d = static_cast<std::uint16_t>(random.below(trial % 2 * 60000 + 99));
    FlatWindow window;
    load_window(table.data(), depth.data(), 11, columns, rows, window);
    std::int32_t readings = 0;
    for (std::uint32_t i = 0; i < 64; ++i) {
      const bool inside = i % 8 < columns && i / 8 < rows;
      const std::uint16_t d = inside ? depth[i / 8 * 11 + i % 8] : std::uint16_t{0};
      ASSERT_EQ(window.low[i], table[d].low);
      ASSERT_EQ(window.high[i], table[d].high);
      readings += d != 0;
    }
    EXPECT_EQ(window.readings, readings);
    EXPECT_FALSE(window.empty);
  }
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
