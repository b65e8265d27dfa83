// Raw clouds: every reading comes back bit for bit, whatever its bits; everything else is the one
// hole; slices keep their limit, decode alone, and hostile ones end with a named status.
#include <gtest/gtest.h>

#include "tests/core/wire/raw_bench.hpp"

namespace planecast {
namespace {

using test::Bytes;
using test::Cloud;
using test::RawBench;

void expect_same(const Cloud& in, const Cloud& out) {
  ASSERT_EQ(in.size(), out.size());
  for (std::size_t i = 0; i < in.size(); ++i) {
    const Point3f expected = test::finite_point(in[i]) ? in[i] : hole_point();
    ASSERT_TRUE(test::same_bits(out[i], expected)) << "point " << i;
  }
}

TEST(RawCloud, EveryReadingComesBackBitForBit) {
  for (std::uint64_t seed = 0; seed < 96; ++seed) {
    SCOPED_TRACE(seed);
    Pcg32 random(seed);
    RawBench b(1 + random.below(90), 1 + random.below(70));
    const Cloud cloud =
        test::random_cloud(random, b.config.camera.width, b.config.camera.height, seed);
    const std::size_t limits[] = {kMinRawSliceBytes, 1190, kFileSliceBytes};
    const auto packets = b.pack(cloud, limits[random.below(3)]);
    expect_same(cloud, b.unpack_all(packets));
    std::uint32_t points = 0;
    for (const TileContent& content : b.contents) points += content.points;
    EXPECT_EQ(points, std::count_if(cloud.begin(), cloud.end(), test::finite_point));
    EXPECT_EQ(points, b.report.points);
    if (HasFatalFailure()) return;
  }
}

TEST(RawCloud, EverySmallSizeComesBack) {
  std::uint64_t seed = 500;
  for (const std::uint32_t width : {1U, 2U, 8U, 9U, 17U}) {
    for (const std::uint32_t height : {1U, 7U, 8U, 17U}) {
      Pcg32 random(++seed);
      RawBench b(width, height);
      const Cloud cloud = test::random_cloud(random, width, height, seed);
      expect_same(cloud, b.unpack_all(b.pack(cloud, 1190)));
    }
  }
}

TEST(RawCloud, PointsOfACameraCostFarLessThanTheirBits) {
  Pcg32 random(600);
  RawBench b(160, 120);
  const Cloud steps = test::random_cloud(random, 160, 120, 1);
  (void)b.pack(steps, kFileSliceBytes);
  EXPECT_TRUE(b.packer.rays().present);
  EXPECT_EQ(b.packer.rays().steps, DepthSteps::kInverse);
  EXPECT_EQ(b.packer.rays().primary, 0);
  EXPECT_LT(b.report.bytes * 8, steps.size() * 24);
  const Cloud noise = test::random_cloud(random, 160, 120, 2);
  (void)b.pack(noise, kFileSliceBytes);
  EXPECT_LE(b.report.bytes, noise.size() * 12 + b.report.slices * 40);
}

TEST(RawCloud, SlicesKeepTheirLimitAndDecodeAloneInAnyOrder) {
  for (std::uint64_t seed = 700; seed < 708; ++seed) {
    Pcg32 random(seed);
    RawBench b(120, 90);
    const Cloud cloud = test::random_cloud(random, 120, 90, seed);
    auto packets = b.pack(cloud, kMinRawSliceBytes);
    const Cloud whole = b.unpack_all(packets);
    for (std::size_t i = 0; i < packets.size(); ++i) {
      ASSERT_LE(packets[i].size(), kMinRawSliceBytes);
      RawBench fresh(120, 90);
      Cloud alone(cloud.size());
      clear_points(alone);
      ASSERT_EQ(fresh.unpack(packets[i], alone), Status::kOk);
      const TileSpan span = tile_span(b.config.camera, b.contents[i].rect);
      for (std::uint32_t at = 0; at < alone.size(); ++at) {
        const std::uint32_t u = at % 120, v = at / 120;
        const bool inside = u >= span.u0 && u < span.u1 && v >= span.v0 && v < span.v1;
        ASSERT_TRUE(test::same_bits(alone[at], inside ? whole[at] : hole_point()));
      }
    }
    std::reverse(packets.begin(), packets.end());
    expect_same(cloud, b.unpack_all(packets));
  }
}

TEST(RawCloud, TheSameCloudsGiveTheSameBytes) {
  Pcg32 random(800);
  RawBench a(60, 50), b(60, 50);
  for (std::uint64_t kind = 0; kind < test::kCloudKinds; ++kind) {
    const Cloud cloud = test::random_cloud(random, 60, 50, kind);
    EXPECT_EQ(a.pack(cloud, 1190), b.pack(cloud, 1190));
  }
}

void expect_named(RawBench& b, const Bytes& packet, int (&seen)[256]) {
  constexpr std::size_t kGuard = 300;
  const std::size_t pixels = b.config.camera.pixels();
  const Point3f wall{test::float_of(0x12345678U), 1, 2};
  Cloud walls(pixels + 2 * kGuard, wall);
  const auto target = std::span<Point3f>(walls).subspan(kGuard, pixels);
  clear_points(target);
  const Status status = b.unpack(packet, target);
  ++seen[static_cast<int>(status)];
  ASSERT_TRUE(test::is_wire_status(status)) << to_string(status);
  for (std::size_t i = 0; i < kGuard; ++i) {
    ASSERT_TRUE(test::same_bits(walls[i], wall));
    ASSERT_TRUE(test::same_bits(walls[walls.size() - 1 - i], wall));
  }
  for (const Point3f& p : target) {
    if (status != Status::kOk) ASSERT_TRUE(test::same_bits(p, hole_point())) << to_string(status);
    if (!test::finite_point(p)) ASSERT_TRUE(test::same_bits(p, hole_point()));
  }
}

TEST(RawCloud, HostileSlicesEndWithANamedStatus) {
  int seen[256] = {};
  for (std::uint64_t seed = 900; seed < 916; ++seed) {
    SCOPED_TRACE(seed);
    Pcg32 random(seed);
    RawBench b(1 + random.below(60), 1 + random.below(40));
    const Cloud cloud =
        test::random_cloud(random, b.config.camera.width, b.config.camera.height, seed);
    const Bytes good = b.pack(cloud, kFileSliceBytes).front();
    for (int i = 0; i < 160; ++i) {
      Bytes packet = good;
      const auto body = static_cast<std::uint32_t>(packet.size() - kPacketHeaderBytes);
      switch (i % 4) {
        case 0:
          packet.resize(kPacketHeaderBytes + random.below(body));
          break;
        case 1:
          packet.resize(packet.size() + 6 + random.below(9));
          break;
        case 2:
          packet[kPacketHeaderBytes + random.below(std::min(body, 70U))] ^=
              static_cast<std::uint8_t>(1U << random.below(8));
          break;
        default:
          packet.resize(kPacketHeaderBytes + random.below(400));
          for (std::size_t at = kPacketHeaderBytes; at < packet.size(); ++at)
            packet[at] = static_cast<std::uint8_t>(random.next());
      }
      test::reseal(packet);
      expect_named(b, packet, seen);
      if (HasFatalFailure()) return;
    }
  }
  for (const Status status : {Status::kTruncated, Status::kFieldRange, Status::kBadSymbol,
                              Status::kTrailingBytes, Status::kOk}) {
    EXPECT_GT(seen[static_cast<int>(status)], 0) << to_string(status);
  }
}

TEST(RawCloud, WrongUseIsTold) {
  Pcg32 random(950);
  RawBench b(20, 10);
  const Cloud cloud = test::random_cloud(random, 20, 10, 0);
  const Bytes packet = b.pack(cloud, 1190).front();
  Cloud out(200);
  TileContent content;
  StreamConfig depth = b.config;
  depth.kind = FrameKind::kDepth;
  EXPECT_EQ(b.unpacker.unpack_slice(depth, RawBench::kHash, packet, out, content),
            Status::kBadConfig);
  EXPECT_EQ(b.unpacker.unpack_slice(b.config, 1, packet, out, content), Status::kUnknownKey);
  EXPECT_EQ(b.unpacker.unpack_slice(b.config, RawBench::kHash, packet,
                                    std::span<Point3f>(out).first(199), content),
            Status::kWrongSize);
  StreamConfig wide = b.config;
  wide.camera.width = 2000;
  Cloud large(20000);
  EXPECT_EQ(b.unpacker.unpack_slice(wide, RawBench::kHash, packet, large, content),
            Status::kTooLarge)
      << "read as a rectangle wider than the layout";
  Bytes space(4000);
  std::vector<SlicePlace> places(10);
  EXPECT_EQ(b.packer.pack(b.config, std::span<const Point3f>(cloud).first(5), {}, 1190, space,
                          places, b.report),
            Status::kWrongSize);
  EXPECT_EQ(b.packer.pack(b.config, cloud, {}, kMinRawSliceBytes - 1, space, places, b.report),
            Status::kBadConfig);
  EXPECT_EQ(b.packer.pack(b.config, cloud, {}, kMinRawSliceBytes, std::span(space).first(60),
                          places, b.report),
            Status::kTooLarge);
}

TEST(OrderedBits, KeepTheOrderOfTheValuesAndComeBack) {
  Pcg32 random(960);
  EXPECT_EQ(ordered_bits(0.0F), ordered_bits(-0.0F) + 1);
  for (int i = 0; i < 100'000; ++i) {
    const float a = test::float_of(random.next()), b = test::float_of(random.next());
    ASSERT_EQ(std::bit_cast<std::uint32_t>(from_ordered_bits(ordered_bits(a))),
              std::bit_cast<std::uint32_t>(a));
    if (a < b) ASSERT_LT(ordered_bits(a), ordered_bits(b));
  }
  EXPECT_EQ(ordered_prediction(NAN), ordered_bits(-3.4028235e38F));
  EXPECT_EQ(ordered_prediction(1e300), ordered_bits(3.4028235e38F));
  EXPECT_EQ(ordered_prediction(-1e300), ordered_bits(-3.4028235e38F));
  EXPECT_EQ(ordered_prediction(1.5), ordered_bits(1.5F));
}

TEST(RawRays, NumbersKeepFortyEightBits) {
  Pcg32 random(970);
  for (int i = 0; i < 10'000; ++i) {
    const double value = test::between(random, -1e3, 1e3);
    const double rounded = round_to_48(value);
    EXPECT_EQ(std::bit_cast<std::uint64_t>(rounded) & 0xffffU, 0U);
    EXPECT_NEAR(rounded, value, std::abs(value) * 0x1p-36);
  }
}

}  // namespace
}  // namespace planecast
