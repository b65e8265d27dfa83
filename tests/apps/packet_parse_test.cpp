#include "apps/common/packet_parse.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "core/base/random.hpp"
#include "transport/assembler.hpp"

namespace planecast {
namespace {

std::vector<std::uint8_t> sealed(const PacketHeader& header, std::size_t body = 40) {
  std::vector<std::uint8_t> packet(kPacketHeaderBytes + body, 0x5a);
  seal_packet(header, packet);
  return packet;
}

PacketHeader slice_of(std::uint32_t frame) {
  PacketHeader header;
  header.stream = 200;
  header.frame = frame;
  header.stamp_offset = 123'456'789'012ULL;
  header.slice = 3;
  header.slice_count = 9;
  header.key_hash = 0xdeadbeef;
  return header;
}

}  // namespace

TEST(PacketParse, ReadsTheIdentityOfASlice) {
  PacketInfo info;
  ASSERT_EQ(parse_planecast_packet(sealed(slice_of(0xfffffe)), info), Status::kOk);
  EXPECT_EQ(info.session, 0xdeadbeefU);
  EXPECT_EQ(info.stream, 200);
  EXPECT_EQ(info.frame, 0xfffffeU);
  EXPECT_EQ(info.slice, 3);
  EXPECT_EQ(info.slice_count, 9);
  EXPECT_FALSE(info.key);
  EXPECT_EQ(info.stamp_ns, 123'456'789'012);
}

TEST(PacketParse, ReadsTheIdentityOfAKeyPacket) {
  PacketHeader header = slice_of(7);
  header.key = true;
  header.slice = header.slice_count = 0;
  PacketInfo info;
  ASSERT_EQ(parse_planecast_packet(sealed(header), info), Status::kOk);
  EXPECT_TRUE(info.key);
  EXPECT_EQ(info.frame, 7U);
  EXPECT_EQ(info.session, 0xdeadbeefU);
}

TEST(PacketParse, RefusesEveryFlippedBitAndEveryCut) {
  const std::vector<std::uint8_t> packet = sealed(slice_of(5));
  PacketInfo info;
  for (std::size_t bit = 0; bit < packet.size() * 8; ++bit) {
    std::vector<std::uint8_t> damaged = packet;
    damaged[bit / 8] = static_cast<std::uint8_t>(damaged[bit / 8] ^ (1U << (bit % 8)));
    EXPECT_NE(parse_planecast_packet(damaged, info), Status::kOk) << "bit " << bit;
  }
  for (std::size_t bytes = 0; bytes < packet.size(); ++bytes)
    EXPECT_NE(parse_planecast_packet({packet.data(), bytes}, info), Status::kOk) << bytes;
}

TEST(PacketParse, FramesCountOnOverTheWrapOfTheWireAndLossIsCountedAcrossIt) {
  AssemblerConfig config;
  config.frame_bits = kPacketFrameBits;
  config.output_frames = 16;
  auto assembler = std::move(Assembler::create(config).value());
  std::vector<std::uint32_t> numbers;
  for (const std::uint32_t frame : {0xfffffdU, 0xfffffeU, 0U, 1U}) {
    PacketHeader header = slice_of(frame);
    header.slice = 0;
    header.slice_count = 1;
    const auto packet = sealed(header);
    PacketInfo info;
    ASSERT_EQ(parse_planecast_packet(packet, info), Status::kOk);
    assembler->push(packet, info, 1'000);
    while (const FrameRef out = assembler->take()) numbers.push_back(out->frame);
  }
  EXPECT_EQ(numbers, (std::vector<std::uint32_t>{0xfffffd, 0xfffffe, 0, 1}));
  const StreamStatistics stream = assembler->statistics().streams[0];
  EXPECT_EQ(stream.frames_lost, 1U);
  EXPECT_EQ(stream.resyncs, 0U);
}

TEST(StampOfOffset, GivesBackEveryStampWithin39HoursOfWhereItIsLookedFor) {
  constexpr std::int64_t kHalf = std::int64_t{1} << 47U;
  Pcg32 random(5);
  const auto any = [&random](std::int64_t below) {
    const std::uint64_t bits = (std::uint64_t{random.next()} << 32U) | random.next();
    return static_cast<std::int64_t>(bits % static_cast<std::uint64_t>(below));
  };
  for (int i = 0; i < 10'000; ++i) {
    const std::int64_t epoch = any(std::numeric_limits<std::int64_t>::max() / 4);
    const std::int64_t stamp = epoch + any(std::numeric_limits<std::int64_t>::max() / 4);
    const std::int64_t offset = (stamp - epoch) & 0xffffffffffff;
    const std::int64_t near = stamp + any(2 * kHalf - 2) - kHalf + 1;
    ASSERT_EQ(stamp_of_offset(epoch, offset, near), stamp) << epoch << ' ' << stamp << ' ' << near;
  }
}

TEST(StampOfOffset, TakesAStampBeforeTheEpoch) {
  const std::int64_t epoch = 5'000;
  const std::int64_t stamp = 4'000;  // a source whose clock went back
  EXPECT_EQ(stamp_of_offset(epoch, (stamp - epoch) & 0xffffffffffff, 4'100), stamp);
}

}  // namespace planecast
