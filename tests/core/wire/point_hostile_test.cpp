// Point slices from anywhere: whatever the bytes say, the unpacker ends with a status, within its
// memory, and leaves what was decoded before alone.
#include <gtest/gtest.h>

#include <set>

#include "tests/core/wire/point_bench.hpp"

namespace planecast {
namespace {

using namespace point_bench;

void seal_again(Packet& packet) {
  PacketHeader header{false, 3, 77, 123456, 0, 1, 0xabcd1234};
  seal_packet(header, packet);
}

std::vector<Packet> packed_cloud(Codec& codec, const std::string& name, std::size_t n) {
  EXPECT_EQ(codec.pack(cloud(name, n, 20000, 9), 1200), Status::kOk);
  return codec.packets();
}

TEST(PointHostile, SpoiltBytesEndWithAStatusAndKeepWhatWasThere) {
  std::mt19937 random(11);
  std::set<Status> seen;
  for (const std::uint32_t tolerance : {0U, 60U}) {
    for (const char* name : {"noisy", "sparse", "equal", "clustered"}) {
      Codec codec(tolerance, 2000);
      const auto packets = packed_cloud(codec, name, 2000);
      for (int round = 0; round < 150; ++round) {
        Packet packet = packets[random() % packets.size()];
        const std::size_t flips = 1 + random() % 4;
        for (std::size_t i = 0; i < flips; ++i) {
          const std::size_t body = packet.size() - kPacketHeaderBytes;
          packet[kPacketHeaderBytes +
                 random() % std::min<std::size_t>(body, round % 2 ? 24 : body)] =
              static_cast<std::uint8_t>(random());
        }
        seal_again(packet);
        Points target(2000, GridPoint{1, 2, 3});
        std::uint32_t used = 7;
        const Status status = codec.unpacker.unpack_slice(codec.coding, codec.identity.key_hash,
                                                          packet, target, used);
        seen.insert(status);
        EXPECT_LE(used, 2000U);
        if (status != Status::kOk) EXPECT_EQ(used, 7U);
        for (int i = 0; i < 7; ++i) EXPECT_EQ(target[i], (GridPoint{1, 2, 3}));
      }
    }
  }
  for (const Status status : seen) {
    const std::set<Status> allowed = {Status::kOk,        Status::kFieldRange,
                                      Status::kBadSymbol, Status::kTooLarge,
                                      Status::kTruncated, Status::kTrailingBytes};
    EXPECT_TRUE(allowed.count(status)) << to_string(status);
  }
  EXPECT_GT(seen.size(), 3U);
}

TEST(PointHostile, EveryCutIsSeen) {
  Codec codec(25, 700);
  const auto packets = packed_cloud(codec, "noisy", 700);
  for (std::size_t bytes = kPacketHeaderBytes; bytes < packets[0].size(); ++bytes) {
    Packet cut(packets[0].begin(), packets[0].begin() + static_cast<std::ptrdiff_t>(bytes));
    seal_again(cut);
    Points target(700);
    std::uint32_t used = 0;
    const Status status =
        codec.unpacker.unpack_slice(codec.coding, codec.identity.key_hash, cut, target, used);
    // Zeros past the end may decode to something else, or stand in for at most eight bytes.
    if (bytes + 8 < packets[0].size()) EXPECT_NE(status, Status::kOk) << bytes;
  }
}

TEST(PointHostile, NamesEveryCase) {
  Codec codec(25, 700);
  const auto packets = packed_cloud(codec, "noisy", 700);
  Points target(700);
  std::uint32_t used = 0;
  const auto decode = [&](const Packet& packet) {
    return codec.unpacker.unpack_slice(codec.coding, codec.identity.key_hash, packet, target, used);
  };
  Packet packet = packets[0];
  packet.resize(packet.size() + 9, 1);  // up to eight could be what the coder left out
  seal_again(packet);
  EXPECT_EQ(decode(packet), Status::kTrailingBytes);
  packet = packets[0];
  packet[kPacketHeaderBytes] |= 0xc0;  // kind 3
  seal_again(packet);
  EXPECT_EQ(decode(packet), Status::kFieldRange);
  PointSliceKind kind{};
  EXPECT_EQ(point_slice_kind(packet, kind), Status::kFieldRange);
  EXPECT_EQ(point_slice_kind(std::span(packet).first(kPacketHeaderBytes), kind),
            Status::kTruncated);
  codec.identity.key_hash ^= 1;
  EXPECT_EQ(decode(packets[0]), Status::kUnknownKey);
  codec.identity.key_hash ^= 1;
  packet = packets[0];
  packet[40] ^= 1;
  EXPECT_EQ(decode(packet), Status::kBadCheck);
  ASSERT_EQ(decode(packets[0]), Status::kOk);
  codec.coding.max_points = used + 1;
  EXPECT_EQ(decode(packets[0]), Status::kTooLarge);
}

}  // namespace
}  // namespace planecast
