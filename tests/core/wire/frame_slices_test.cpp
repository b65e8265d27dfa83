// Slices: none too large, each decodes alone and in any order, together they cover the image once,
// and one that is lost leaves only its own rectangle empty.
#include <gtest/gtest.h>

#include <numeric>

#include "tests/core/wire/wire_bench.hpp"

namespace planecast {
namespace {

using test::Bytes;
using test::Image;
using test::SurfaceMode;
using test::WireBench;

struct Packed {
  WireBench bench;
  Image image;
  std::vector<Bytes> packets;
  Image whole;
};

Packed pack_random(std::uint64_t seed, std::size_t slice_bytes, std::uint32_t side = 260) {
  Pcg32 random(seed);
  StreamConfig config = test::random_config(random, 8);
  config.camera = test::random_camera(random, side + random.below(40), side, 1.2, true);
  Packed p{WireBench(config), {}, {}, {}};
  p.image = test::random_image(random, config.camera, seed);
  p.bench.find_surfaces(p.image, static_cast<SurfaceMode>(seed % 3), random);
  p.packets = p.bench.pack(p.image, slice_bytes);
  p.whole = p.bench.unpack_all(p.packets);
  return p;
}

TEST(FrameSlices, NoneExceedsItsLimitAndAllAreNumbered) {
  for (const std::size_t limit : {kMinSliceBytes, std::size_t{333}, std::size_t{1190}}) {
    for (std::uint64_t seed = 0; seed < 9; ++seed) {
      const Packed p = pack_random(seed, limit);
      std::size_t bytes = 0;
      for (std::size_t i = 0; i < p.packets.size(); ++i) {
        PacketHeader header;
        ASSERT_EQ(open_packet(p.packets[i], header), Status::kOk);
        ASSERT_LE(p.packets[i].size(), limit);
        EXPECT_FALSE(header.key);
        EXPECT_EQ(header.slice, i);
        EXPECT_EQ(header.slice_count, p.packets.size());
        EXPECT_EQ(header.frame, 5U);
        EXPECT_EQ(header.stamp_offset, 17U);
        EXPECT_EQ(header.stream, p.bench.config.stream);
        bytes += p.packets[i].size();
      }
      EXPECT_EQ(bytes, p.bench.report.bytes);
      EXPECT_LE(bytes, frame_capacity(p.bench.config.camera.width, p.bench.config.camera.height));
    }
  }
}

// Columns end in slices of less; all others end for want of room for one more row of blocks.
TEST(FrameSlices, AreFullButForTheLastOfAColumn) {
  StreamConfig config;
  config.camera.width = 320;
  config.camera.height = 240;
  config.camera.fx_q16 = config.camera.fy_q16 = 300U << 16U;
  config.camera.cx_q16 = 160 << 16;
  config.camera.cy_q16 = 120 << 16;
  config.camera.unit_pm = 1'000'000'000;
  config.tolerance = ToleranceKind::kLossless;
  WireBench bench(config);
  Pcg32 random(3);
  Image image(config.camera.pixels());
  for (std::uint16_t& depth : image) depth = static_cast<std::uint16_t>(2000 + random.below(5));
  bench.find_surfaces(image, SurfaceMode::kNone, random);
  const auto packets = bench.pack(image, 1190);
  EXPECT_EQ(bench.unpack_all(packets), image);
  std::size_t inner = 0;
  for (std::size_t i = 0; i < packets.size(); ++i) {
    const TileRect& rect = bench.contents[i].rect;
    if (rect.by + rect.bh == 30) continue;
    ++inner;
    const double row = static_cast<double>(packets[i].size()) / rect.bh;
    EXPECT_GT(static_cast<double>(packets[i].size()) + 1.15 * row + 8, 1190) << i;
  }
  EXPECT_GT(inner, 6U);
}

TEST(FrameSlices, CoverEveryBlockExactlyOnce) {
  for (std::uint64_t seed = 20; seed < 29; ++seed) {
    const Packed p = pack_random(seed, 400);
    const CameraModel& camera = p.bench.config.camera;
    std::vector<int> covered(std::size_t{blocks_wide(camera)} * blocks_high(camera));
    for (const TileContent& content : p.bench.contents) {
      const TileRect& r = content.rect;
      for (std::uint32_t by = r.by; by < r.by + r.bh; ++by) {
        for (std::uint32_t bx = r.bx; bx < r.bx + r.bw; ++bx)
          ++covered[std::size_t{by} * blocks_wide(camera) + bx];
      }
    }
    EXPECT_EQ(std::count(covered.begin(), covered.end(), 1), std::ssize(covered)) << seed;
  }
}

TEST(FrameSlices, DecodeInAnyOrderAndTwice) {
  for (std::uint64_t seed = 40; seed < 49; ++seed) {
    Packed p = pack_random(seed, 500);
    Pcg32 random(seed);
    for (std::size_t i = p.packets.size(); i > 1; --i)
      std::swap(p.packets[i - 1], p.packets[random.below(static_cast<std::uint32_t>(i))]);
    p.packets.push_back(p.packets.front());
    EXPECT_EQ(p.bench.unpack_all(p.packets), p.whole);
  }
}

TEST(FrameSlices, EachDecodesAloneInAFreshDecoder) {
  for (std::uint64_t seed = 50; seed < 53; ++seed) {
    const Packed p = pack_random(seed, 700, 120);
    for (const Bytes& packet : p.packets) {
      WireBench fresh(p.bench.config);
      Image depth(p.whole.size());
      ASSERT_EQ(fresh.unpack(packet, depth), Status::kOk);
      const TileSpan span = tile_span(fresh.config.camera, fresh.contents.back().rect);
      for (std::uint32_t v = 0, i = 0; v < fresh.config.camera.height; ++v) {
        for (std::uint32_t u = 0; u < fresh.config.camera.width; ++u, ++i) {
          const bool inside = u >= span.u0 && u < span.u1 && v >= span.v0 && v < span.v1;
          ASSERT_EQ(depth[i], inside ? p.whole[i] : 0);
        }
      }
    }
  }
}

TEST(FrameSlices, ALostSliceLeavesOnlyItsRectangleEmpty) {
  for (std::uint64_t seed = 60; seed < 66; ++seed) {
    Packed p = pack_random(seed, 600);
    const std::vector<TileContent> contents = p.bench.contents;
    const std::size_t lost = p.packets.size() / 2;
    std::vector<Bytes> rest = p.packets;
    rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(lost));
    const Image out = p.bench.unpack_all(rest);
    const CameraModel& camera = p.bench.config.camera;
    const TileSpan span = tile_span(camera, contents[lost].rect);
    for (std::uint32_t v = 0, i = 0; v < camera.height; ++v) {
      for (std::uint32_t u = 0; u < camera.width; ++u, ++i) {
        const bool inside = u >= span.u0 && u < span.u1 && v >= span.v0 && v < span.v1;
        ASSERT_EQ(out[i], inside ? 0 : p.whole[i]);
      }
    }
  }
}

TEST(FrameSlices, TilesOfWideImagesStayWithinTheSyntax) {
  Pcg32 random(70);
  StreamConfig config;
  config.camera = test::random_camera(random, 5000, 9, 1.0, false);
  WireBench b(config);
  const Image image(config.camera.pixels(), 1234);
  const auto packets = b.pack(image, kFileSliceBytes);
  EXPECT_GE(packets.size(), 3U);
  EXPECT_EQ(b.unpack_all(packets), image);
}

TEST(FrameSlices, SlicesOfAnotherKeyAndKeyPacketsAreTold) {
  Packed p = pack_random(80, 1190, 40);
  Image depth(p.whole.size());
  TileContent content;
  EXPECT_EQ(p.bench.unpacker.unpack_slice(p.bench.tables.coding(), WireBench::kHash + 1,
                                          p.packets[0], {depth, {}}, content),
            Status::kUnknownKey);
  Bytes key = p.packets[0];
  PacketHeader header;
  header.key = true;
  seal_packet(header, key);
  EXPECT_EQ(p.bench.unpack(key, depth), Status::kFieldRange);
}

TEST(FrameSlices, TooSmallALimitOrABufferIsRefused) {
  Packed p = pack_random(82, 1190, 40);  // noise
  std::vector<Bytes> packets;
  EXPECT_EQ(p.bench.try_pack(p.image, kMinSliceBytes - 1, packets), Status::kBadConfig);
  Bytes small(100);
  std::vector<SlicePlace> places(1000);
  const FrameModel model{p.image, p.bench.labels, {}, 0};
  EXPECT_EQ(
      p.bench.packer.pack(p.bench.tables.coding(), model, {}, 1190, small, places, p.bench.report),
      Status::kTooLarge);
  Bytes large(1 << 20);
  EXPECT_EQ(p.bench.packer.pack(p.bench.tables.coding(), model, {}, kMinSliceBytes, large,
                                std::span(places).first(1), p.bench.report),
            Status::kTooLarge);
}

TEST(FrameSlices, LabelsNameTheSurfacesOfTheirTile) {
  Pcg32 random(82);
  StreamConfig config;
  config.camera = test::random_camera(random, 64, 64, 1.0, false);
  config.tolerance = ToleranceKind::kSurfaces;
  config.noise = {NoiseModel::Kind::kTof, 10'000'000};
  config.sigmas_q16 = 3U << 16U;
  config.camera.unit_pm = 1'000'000'000;
  WireBench b(config);
  Image image(64 * 64, 2000);
  for (std::size_t i = 0; i < image.size(); ++i) {
    if (i % 64 >= 32) image[i] = 3000;
    if (i % 97 == 0) image[i] = 0;
    if (i % 101 == 0) image[i] = 500;
  }
  const auto plane = [](int depth) {
    return Surface{0, 0, static_cast<std::int32_t>(0x1p31 / depth)};
  };
  b.surfaces[0] = plane(2000);
  b.surfaces[1] = plane(3000);
  b.surface_count = 2;
  for (std::size_t i = 0; i < b.labels.size(); ++i) b.labels[i].first = i % 8 < 4 ? 1 : 2;
  const auto packets = b.pack(image, kFileSliceBytes);
  ASSERT_EQ(packets.size(), 1U);
  Image out(image.size()), labels;
  ASSERT_EQ(b.unpack(packets[0], out, &labels), Status::kOk);
  for (std::size_t i = 0; i < image.size(); ++i) {
    const bool off = image[i] == 0 || image[i] == 500;
    EXPECT_EQ(labels[i], off ? 0 : (i % 64 < 32 ? 1 : 2)) << i;
  }
}

}  // namespace
}  // namespace planecast
