// Bytes from anywhere: whatever a slice holds, decoding ends with a named status, writes nothing
// outside the image, and leaves no half-decoded tile behind.
#include <gtest/gtest.h>

#include "tests/core/wire/wire_bench.hpp"

namespace planecast {
namespace {

using test::Bytes;
using test::Image;
using test::SurfaceMode;
using test::WireBench;

constexpr std::size_t kGuard = 4096;

// Decodes into an image between two walls of known values.
struct Target {
  Image walls;
  std::vector<std::uint8_t> label_walls;
  std::size_t pixels;

  explicit Target(std::size_t count)
      : walls(count + 2 * kGuard, 0x5a5a), label_walls(count + 2 * kGuard, 0x5a), pixels(count) {}

  Status decode(WireBench& b, const Bytes& packet, TileContent& content) {
    std::fill_n(walls.begin() + kGuard, pixels, std::uint16_t{0});
    std::fill_n(label_walls.begin() + kGuard, pixels, std::uint8_t{0});
    const TileTarget target{std::span(walls).subspan(kGuard, pixels),
                            std::span(label_walls).subspan(kGuard, pixels)};
    return b.unpacker.unpack_slice(b.tables.coding(), WireBench::kHash, packet, target, content);
  }

  void expect_intact() const {
    for (std::size_t i = 0; i < kGuard; ++i) {
      ASSERT_EQ(walls[i], 0x5a5a);
      ASSERT_EQ(walls[walls.size() - 1 - i], 0x5a5a);
      ASSERT_EQ(label_walls[i], 0x5a);
      ASSERT_EQ(label_walls[label_walls.size() - 1 - i], 0x5a);
    }
  }

  bool empty() const {
    return std::all_of(walls.begin() + kGuard, walls.end() - kGuard,
                       [](auto d) { return d == 0; }) &&
           std::all_of(label_walls.begin() + kGuard, label_walls.end() - kGuard,
                       [](auto l) { return l == 0; });
  }
};

struct Seen {
  int count[256] = {};
  void note(Status status) { ++count[static_cast<int>(status)]; }
  int of(Status status) const { return count[static_cast<int>(status)]; }
};

void expect_sane(WireBench& b, Target& target, const Bytes& packet, Seen& seen) {
  TileContent content;
  const Status status = target.decode(b, packet, content);
  seen.note(status);
  ASSERT_TRUE(test::is_wire_status(status)) << to_string(status);
  target.expect_intact();
  if (status != Status::kOk) {
    ASSERT_TRUE(target.empty()) << to_string(status);
    return;
  }
  const CameraModel& camera = b.config.camera;
  ASSERT_LE(content.rect.bx + content.rect.bw, blocks_wide(camera));
  ASSERT_LE(content.rect.by + content.rect.bh, blocks_high(camera));
  ASSERT_LE(content.points, target.pixels);
  ASSERT_LE(content.surfaces, static_cast<std::uint32_t>(kMaxSurfaces));
}

Bytes slice_of(Pcg32& random, const WireBench& b, std::size_t body) {
  Bytes packet(kPacketHeaderBytes + body);
  for (auto& byte : packet) byte = static_cast<std::uint8_t>(random.next());
  seal_packet({false, b.config.stream, 1, 2, 0, 1, WireBench::kHash}, packet);
  return packet;
}

// The head of a tile that is the first block of an image of 16 x 16 pixels.
void code_one_block(RangeEncoder& coder, std::uint32_t modelled) {
  coder.raw(modelled, 1);
  for (int field = 0; field < 4; ++field) coder.raw(0, 1);
}

StreamConfig hostile_config(Pcg32& random) {
  return test::random_config(random, random.below(3) == 0 ? 20 : 150);
}

TEST(HostileSlices, RandomBytesEndWithANamedStatus) {
  Seen seen;
  for (std::uint64_t seed = 0; seed < 24; ++seed) {
    SCOPED_TRACE(seed);
    Pcg32 random(seed);
    WireBench b(hostile_config(random));
    Target target(b.config.camera.pixels());
    for (int i = 0; i < 150; ++i) {
      const std::size_t longest = i % 10 == 0 ? 3000 : 60;
      Bytes packet = slice_of(random, b, random.below(static_cast<std::uint32_t>(longest)));
      // A modelled tile at the origin gets further than a random rectangle.
      if (i % 2 == 0 && packet.size() > 26) packet[24] = packet[25] = packet[26] = 0;
      test::reseal(packet);
      expect_sane(b, target, packet, seen);
      if (HasFatalFailure()) return;
    }
  }
  for (const Status status :
       {Status::kTruncated, Status::kFieldRange, Status::kBadSymbol, Status::kTrailingBytes}) {
    EXPECT_GT(seen.of(status), 0) << to_string(status);
  }
}

TEST(HostileSlices, ChangedBitsEndWithANamedStatus) {
  Seen seen;
  for (std::uint64_t seed = 100; seed < 124; ++seed) {
    SCOPED_TRACE(seed);
    Pcg32 random(seed);
    WireBench b(test::random_config(random, 70));
    if (seed >= 118) b.deadline = test::past_deadline();
    const Image image = test::random_image(random, b.config.camera, seed);
    b.find_surfaces(image, static_cast<SurfaceMode>(seed % 3), random);
    Target target(image.size());
    for (const Bytes& good : b.pack(image, 700)) {
      for (int i = 0; i < 40; ++i) {
        Bytes packet = good;
        const int flips = 1 + static_cast<int>(random.below(3));
        for (int f = 0; f < flips; ++f) {
          const auto size = static_cast<std::uint32_t>(packet.size() - kPacketHeaderBytes);
          const std::uint32_t reach = random.below(2) != 0 ? size : std::min(size, 24U);
          packet[kPacketHeaderBytes + random.below(reach)] ^=
              static_cast<std::uint8_t>(1U << random.below(8));
        }
        test::reseal(packet);
        expect_sane(b, target, packet, seen);
        if (HasFatalFailure()) return;
      }
    }
  }
  EXPECT_GT(seen.of(Status::kBadSymbol) + seen.of(Status::kTruncated), 0);
}

TEST(HostileSlices, CutAndLengthenedSlicesEndWithANamedStatus) {
  Seen seen;
  for (std::uint64_t seed = 200; seed < 213; ++seed) {
    Pcg32 random(seed);
    WireBench b(test::random_config(random, 40));
    if (seed >= 209) b.deadline = test::past_deadline();
    const Image image = test::random_image(random, b.config.camera, seed);
    b.find_surfaces(image, static_cast<SurfaceMode>(seed % 3), random);
    Target target(image.size());
    const Bytes good = b.pack(image, kFileSliceBytes).front();
    TileContent content;
    for (std::size_t size = kPacketHeaderBytes; size < good.size();
         size += 1 + (good.size() > 600 ? random.below(30) : 0)) {
      Bytes packet(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size));
      PacketHeader header;
      ASSERT_EQ(open_packet(packet, header), Status::kBadCheck) << "the check sees the cut";
      test::reseal(packet);
      expect_sane(b, target, packet, seen);
      if (HasFatalFailure()) return;
    }
    Bytes longer = good;
    longer.resize(good.size() + 9);
    test::reseal(longer);
    EXPECT_EQ(target.decode(b, longer, content), Status::kTrailingBytes);
  }
  EXPECT_GT(seen.of(Status::kTruncated), 20);
}

TEST(HostileSlices, AnEmptyBodyForTheLargestTileStopsEarly) {
  Pcg32 random(300);
  StreamConfig config;
  config.camera = test::random_camera(random, 640, 480, 1.0, false);
  WireBench b(config);
  Target target(config.camera.pixels());
  TileContent content;
  // Verbatim, whole image, then nothing: the first missing rows end it.
  Bytes packet = slice_of(random, b, 8);
  RangeEncoder coder{std::span(packet).subspan(kPacketHeaderBytes)};
  coder.raw(kVerbatimTile, 1);
  coder.raw(0, position_bits(80));
  coder.raw(0, position_bits(60));
  coder.raw(79, position_bits(80));
  coder.raw(59, position_bits(60));
  coder.raw(kCountsTile, 1);
  packet.resize(kPacketHeaderBytes + coder.finish());
  test::reseal(packet);
  EXPECT_EQ(target.decode(b, packet, content), Status::kTruncated);
  EXPECT_TRUE(target.empty());
}

TEST(HostileSlices, ARunBeyondItsTileIsRefused) {
  Pcg32 random(302);
  StreamConfig config;
  config.camera = test::random_camera(random, 16, 16, 1.0, false);
  WireBench b(config);
  Target target(config.camera.pixels());
  TileContent content;
  for (const std::uint32_t run : {63U, 64U, 67U}) {  // one block holds 64 pixels, the last a miss
    Bytes packet = slice_of(random, b, 64);
    RangeEncoder coder{std::span(packet).subspan(kPacketHeaderBytes)};
    code_one_block(coder, kVerbatimTile);
    coder.raw(kRunTile, 1);
    SymbolModel runs, misses;
    coder.symbol(runs, 10);
    coder.raw(run - 36, 5);
    if (run < 64) coder.symbol(misses, 0);
    packet.resize(kPacketHeaderBytes + coder.finish());
    test::reseal(packet);
    EXPECT_EQ(target.decode(b, packet, content), run < 64 ? Status::kOk : Status::kBadSymbol);
    EXPECT_EQ(target.empty(), run >= 64);
  }
}

TEST(HostileSlices, CoefficientsPastThirtyBitsAreRefused) {
  Pcg32 random(301);
  StreamConfig config;
  config.camera = test::random_camera(random, 16, 16, 1.0, false);
  WireBench b(config);
  Target target(config.camera.pixels());
  for (const std::uint32_t shift : {0U, 10U, 31U}) {
    Bytes packet = slice_of(random, b, 64);
    RangeEncoder coder{std::span(packet).subspan(kPacketHeaderBytes)};
    code_one_block(coder, kModelled);
    coder.raw(1000, 16);
    coder.raw(1, 6);
    coder.raw(shift, 5);
    coder.raw(shift % 2, 1);  // of degree one or two
    coder.raw(31 - std::min(shift, 30U), 5);
    packet.resize(kPacketHeaderBytes + coder.finish());
    test::reseal(packet);
    TileContent content;
    EXPECT_EQ(target.decode(b, packet, content), Status::kFieldRange) << shift;
  }
}

TEST(HostileSlices, TheLargestCoefficientsTravel) {
  Pcg32 random(302);
  StreamConfig config;
  config.camera = test::random_camera(random, 16, 16, 1.0, false);
  WireBench b(config);
  b.surface_count = 1;
  constexpr std::int32_t kMost = kMaxSurfaceCoefficient;
  b.surfaces[0] = {kMost, -kMost, kMost, -kMost, kMost, kMost};
  for (BlockLabel& label : b.labels) label.first = 1;
  const Image image = test::random_image(random, config.camera, 0);
  EXPECT_EQ(b.unpack_all(b.pack(image, kFileSliceBytes)), image);
  EXPECT_EQ(b.contents[0].surface[0], b.surfaces[0]);
}

}  // namespace
}  // namespace planecast
