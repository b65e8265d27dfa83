// The packet header: fields survive, every changed bit is caught, reserved bits are refused.
#include "core/wire/packet_header.hpp"

#include <gtest/gtest.h>

#include "tests/core/wire/wire_bench.hpp"

namespace planecast {
namespace {

using test::Bytes;
using test::reseal;

PacketHeader random_header(Pcg32& random) {
  PacketHeader h;
  h.key = random.below(4) == 0;
  h.stream = static_cast<std::uint8_t>(random.next());
  h.frame = random.next() & kFrameNumberMask;
  h.stamp_offset = (std::uint64_t{random.next() & 0xffffU} << 32U) | random.next();
  h.key_hash = random.next();
  if (!h.key) {
    h.slice_count = static_cast<std::uint16_t>(1 + random.below(65535));
    h.slice = static_cast<std::uint16_t>(random.below(h.slice_count));
  }
  return h;
}

Bytes random_packet(Pcg32& random, const PacketHeader& header, std::size_t body) {
  Bytes packet(kPacketHeaderBytes + body);
  for (auto& b : packet) b = static_cast<std::uint8_t>(random.next());
  seal_packet(header, packet);
  return packet;
}

TEST(PacketHeader, EveryFieldComesBack) {
  Pcg32 random(1);
  for (int i = 0; i < 2000; ++i) {
    const PacketHeader in = random_header(random);
    PacketHeader out;
    ASSERT_EQ(open_packet(random_packet(random, in, random.below(100)), out), Status::kOk);
    ASSERT_EQ(in, out);
  }
}

TEST(PacketHeader, EveryChangedBitOfHeaderAndBodyIsRefused) {
  Pcg32 random(2);
  for (int i = 0; i < 10; ++i) {
    Bytes packet = random_packet(random, random_header(random), 1 + random.below(60));
    for (std::size_t bit = 0; bit < packet.size() * 8; ++bit) {
      packet[bit / 8] ^= static_cast<std::uint8_t>(1U << (bit % 8));
      PacketHeader out;
      const Status expected = bit < 4   ? Status::kUnsupportedVersion
                              : bit < 8 ? Status::kBadMagic
                                        : Status::kBadCheck;
      ASSERT_EQ(open_packet(packet, out), expected) << bit;
      packet[bit / 8] ^= static_cast<std::uint8_t>(1U << (bit % 8));
    }
  }
}

TEST(PacketHeader, EveryCutAndEveryAddedByteIsRefused) {
  Pcg32 random(3);
  Bytes packet = random_packet(random, random_header(random), 40);
  PacketHeader out;
  for (std::size_t size = 0; size < packet.size(); ++size) {
    const Status status = open_packet(std::span(packet).first(size), out);
    EXPECT_EQ(status, size < kPacketHeaderBytes ? Status::kTruncated : Status::kBadCheck);
  }
  packet.push_back(0);
  EXPECT_EQ(open_packet(packet, out), Status::kBadCheck);
}

TEST(PacketHeader, ReservedFlagBitsAreRefusedThoughTheCheckFits) {
  Pcg32 random(4);
  for (int bit = 1; bit < 8; ++bit) {
    Bytes packet = random_packet(random, random_header(random), 10);
    packet[1] |= static_cast<std::uint8_t>(1U << bit);
    reseal(packet);
    PacketHeader out;
    EXPECT_EQ(open_packet(packet, out), Status::kReservedBits) << bit;
  }
}

TEST(PacketHeader, SliceNumbersOutOfRangeAreRefused) {
  Pcg32 random(5);
  PacketHeader h = random_header(random), out;
  h.key = false;
  h.slice_count = 0;
  EXPECT_EQ(open_packet(random_packet(random, h, 4), out), Status::kFieldRange);
  h.slice_count = h.slice = 7;
  EXPECT_EQ(open_packet(random_packet(random, h, 4), out), Status::kFieldRange);
  h.key = true;
  EXPECT_EQ(open_packet(random_packet(random, h, 4), out), Status::kFieldRange);
  h.slice = 0;
  EXPECT_EQ(open_packet(random_packet(random, h, 4), out), Status::kFieldRange);
}

TEST(PacketHeader, NumbersWrapAtTheirWidth) {
  PacketHeader in, out;
  in.slice_count = 1;
  in.frame = 0x01000002;
  in.stamp_offset = 0x0001000000000003ULL;
  Bytes packet(kPacketHeaderBytes);
  seal_packet(in, packet);
  ASSERT_EQ(open_packet(packet, out), Status::kOk);
  EXPECT_EQ(out.frame, 2U);
  EXPECT_EQ(out.stamp_offset, 3U);
}

TEST(PacketHeader, BytesLieWhereTheDocumentSays) {
  const PacketHeader h{false, 0x11, 0x445566, 0x0a0b0c0d0e0fULL, 0x0102, 0x0304, 0xcafef00dU};
  Bytes packet(kPacketHeaderBytes);
  seal_packet(h, packet);
  const Bytes expected = {0xc0, 0x00, 0x11, 0x66, 0x55, 0x44, 0x0f, 0x0e, 0x0d, 0x0c,
                          0x0b, 0x0a, 0x02, 0x01, 0x04, 0x03, 0x0d, 0xf0, 0xfe, 0xca};
  EXPECT_EQ(Bytes(packet.begin(), packet.begin() + 20), expected);
  EXPECT_EQ(load_le<std::uint32_t>(packet.data() + 20), crc32c(expected));
  // CRC-32C's own check value.
  const Bytes digits = {'1', '2', '3', '4', '5', '6', '7', '8', '9'};
  EXPECT_EQ(crc32c(digits), 0xe3069283U);
}

}  // namespace
}  // namespace planecast
