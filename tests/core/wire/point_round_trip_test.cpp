// The contract of the point codec, against brute force, for clouds of every sort.
#include <gtest/gtest.h>

#include <numeric>

#include "tests/core/wire/point_bench.hpp"

namespace planecast {
namespace {

using namespace point_bench;

void expect_contract(const Points& in, std::uint32_t tolerance, std::size_t slice_bytes,
                     const std::string& what) {
  SCOPED_TRACE(what + ", tolerance " + std::to_string(tolerance) + ", slices of " +
               std::to_string(slice_bytes));
  Codec codec(tolerance, static_cast<std::uint32_t>(std::max<std::size_t>(in.size(), 1)));
  ASSERT_EQ(codec.pack(in, slice_bytes), Status::kOk);
  EXPECT_EQ(codec.report.points, in.size());
  auto packets = codec.packets();
  ASSERT_FALSE(packets.empty());
  for (std::size_t i = 0; i < packets.size(); ++i) {
    EXPECT_LE(packets[i].size(), slice_bytes);
    PacketHeader header;
    ASSERT_EQ(open_packet(packets[i], header), Status::kOk);
    EXPECT_EQ(header.slice, i);
    EXPECT_EQ(header.slice_count, packets.size());
  }
  std::reverse(packets.begin(), packets.end());
  Points out;
  ASSERT_EQ(codec.unpack(packets, out), Status::kOk);
  EXPECT_EQ(broken_contract(in, out, tolerance), "");
}

TEST(PointRoundTrip, BoundHoldsBothWaysForCloudsOfEverySort) {
  unsigned seed = 1;
  for (const std::string& name : cloud_names())
    for (const std::uint32_t tolerance : {1U, 2U, 9U, 100U, 5000U})
      expect_contract(cloud(name, 450, 20000, ++seed), tolerance, 1200, name);
}

TEST(PointRoundTrip, LosslessGivesTheSameMultiset) {
  unsigned seed = 100;
  for (const std::string& name : cloud_names())
    for (const std::int32_t size : {2, 300, 1000000})
      expect_contract(cloud(name, 2000, size, ++seed), 0, 1200, name);
}

TEST(PointRoundTrip, SlicesOfEverySizeKeepTheContract) {
  unsigned seed = 200;
  for (const std::string& name : cloud_names())
    for (const std::size_t slice : {kMinPointSliceBytes, std::size_t{500}, kFileSliceBytes})
      for (const std::uint32_t tolerance : {0U, 50U})
        expect_contract(cloud(name, 450, 5000, ++seed), tolerance, slice, name);
}

TEST(PointRoundTrip, FewPointsWork) {
  for (const std::uint32_t tolerance : {0U, 10U, kMaxPointTolerance}) {
    expect_contract({}, tolerance, 1200, "none");
    expect_contract({{5, -6, 7}}, tolerance, 1200, "one");
    expect_contract({{5, -6, 7}, {5, -6, 7}}, tolerance, 1200, "twice the same");
    expect_contract({{-2147483647 - 1, 2147483647, 0}, {2147483647, -5, -9}, {0, 0, 0}}, tolerance,
                    1200, "three, far apart");
  }
}

TEST(PointRoundTrip, DuplicatesComeBackAsOftenAsTheyWentIn) {
  Points in(900, {1000, 2000, 3000});
  in.resize(1000, {-50000, 60000, 9});
  in.push_back({400000, 1, 1});
  for (const std::uint32_t tolerance : {0U, 40U}) {
    Codec codec(tolerance, 1001);
    ASSERT_EQ(codec.pack(in, 1200), Status::kOk);
    Points out;
    ASSERT_EQ(codec.unpack(codec.packets(), out), Status::kOk);
    const auto near = [&](std::int32_t x) {
      return std::count_if(out.begin(), out.end(),
                           [&](const GridPoint& p) { return std::abs(p.x - x) <= 40; });
    };
    EXPECT_EQ(near(1000), 900);
    EXPECT_EQ(near(-50000), 100);
    EXPECT_EQ(near(400000), 1);
  }
}

TEST(PointRoundTrip, ALostSliceLosesOnlyItsOwnPoints) {
  const Points in = cloud("noisy", 5000, 20000, 5);
  Codec codec(30, 5000);
  ASSERT_EQ(codec.pack(in, 1200), Status::kOk);
  auto packets = codec.packets();
  ASSERT_GT(packets.size(), 3U);
  Points all, left, alone;
  ASSERT_EQ(codec.unpack(packets, all), Status::kOk);
  ASSERT_EQ(codec.unpack({packets[1]}, alone), Status::kOk);
  packets.erase(packets.begin() + 1);
  ASSERT_EQ(codec.unpack(packets, left), Status::kOk);
  left.insert(left.end(), alone.begin(), alone.end());
  EXPECT_EQ(sorted(all), sorted(left));
}

TEST(PointRoundTrip, GoesOnAfterSlicesThatAreThere) {
  const Points in = cloud("plane", 2000, 9000, 6);
  const PointCoding coding{20, 2000};
  Codec codec(20, 2000);
  Packet packed(point_frame_capacity(2000) + 100);
  std::vector<SlicePlace> places(point_slice_capacity(2000, 1200) + 1);
  packed[kPacketHeaderBytes] = 0x80;  // a body of kind kPatches
  places[0] = {0, 40};
  FrameReport report;
  report.slices = 1;
  report.bytes = 40;
  report.surfaces = 2;
  ASSERT_EQ(codec.packer.pack(coding, in, codec.identity, 1200, packed, places, report),
            Status::kOk);
  EXPECT_EQ(report.points, 2000U);
  EXPECT_EQ(report.surfaces, 2U);
  Points out(2000);
  std::uint32_t used = 0;
  for (std::uint32_t i = 0; i < report.slices; ++i) {
    const std::span packet(packed.data() + places[i].offset, places[i].bytes);
    PacketHeader header;
    ASSERT_EQ(open_packet(packet, header), Status::kOk);
    EXPECT_EQ(header.slice, i);
    EXPECT_EQ(header.slice_count, report.slices);
    PointSliceKind kind{};
    ASSERT_EQ(point_slice_kind(packet, kind), Status::kOk);
    EXPECT_EQ(kind == PointSliceKind::kPatches, i == 0);
    if (i == 0) continue;
    ASSERT_EQ(codec.unpacker.unpack_slice(coding, codec.identity.key_hash, packet, out, used),
              Status::kOk);
  }
  EXPECT_EQ(used, 2000U);
  EXPECT_EQ(broken_contract(in, out, 20), "");
}

TEST(PointRoundTrip, SaysWhatIsTooSmallOrTooLarge) {
  const Points in = cloud("volume", 1000, 9000, 7);
  Codec codec(0, 1000);
  EXPECT_EQ(codec.pack(in, kMinPointSliceBytes - 1), Status::kBadConfig);
  codec.coding.tolerance = kMaxPointTolerance + 1;
  EXPECT_EQ(codec.pack(in, 1200), Status::kBadConfig);
  codec.coding = {0, 999};
  EXPECT_EQ(codec.pack(in, 1200), Status::kFrameTooLarge);
  codec.coding = {0, 1001};
  EXPECT_EQ(codec.pack(cloud("volume", 1001, 9, 7), 1200), Status::kFrameTooLarge);
  codec.coding = {0, 1000};
  FrameReport report;
  Packet small(100);
  std::vector<SlicePlace> places(100);
  EXPECT_EQ(codec.packer.pack(codec.coding, in, codec.identity, 1200, small, places, report),
            Status::kTooLarge);
  Packet packed(point_frame_capacity(1000));
  report = {};
  EXPECT_EQ(codec.packer.pack(codec.coding, in, codec.identity, 1200, packed,
                              std::span(places).first(1), report),
            Status::kTooLarge);
}

}  // namespace
}  // namespace planecast
