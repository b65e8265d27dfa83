// The key packet: every valid configuration survives, no other body is taken for one.
#include "core/wire/key_packet.hpp"

#include <gtest/gtest.h>

#include "core/wire/packet_header.hpp"
#include "tests/core/wire/wire_bench.hpp"

namespace planecast {
namespace {

using test::Bytes;

Bytes body_of(const StreamConfig& config) {
  Bytes out(kMaxKeyBodyBytes);
  const std::size_t size = write_key_body(config, out);
  EXPECT_GT(size, 0U);
  out.resize(size);
  return out;
}

StreamConfig config_of(std::uint64_t seed) {
  Pcg32 random(seed);
  return test::random_config(random, 400, true);
}

TEST(KeyPacket, EveryValidConfigurationComesBack) {
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    const StreamConfig in = config_of(seed);
    StreamConfig out;
    ASSERT_EQ(read_key_body(body_of(in), out), Status::kOk) << seed;
    ASSERT_EQ(in, out) << seed;
  }
}

TEST(KeyPacket, AnyChangedByteIsRefusedOrGivesThatVeryConfiguration) {
  int refused = 0, taken = 0;
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    Bytes body = body_of(config_of(seed));
    for (std::size_t i = 0; i < body.size(); ++i) {
      const std::uint8_t kept = body[i];
      for (int value = 0; value < 256; ++value) {
        body[i] = static_cast<std::uint8_t>(value);
        StreamConfig out;
        const Status status = read_key_body(body, out);
        ASSERT_TRUE(test::is_wire_status(status)) << to_string(status);
        if (status == Status::kOk) {
          ++taken;
          ASSERT_EQ(check_config(out), Status::kOk);
          ASSERT_EQ(body_of(out), body) << "byte " << i << " = " << value;
        } else {
          ++refused;
        }
      }
      body[i] = kept;
    }
  }
  EXPECT_GT(refused, 10'000);
  EXPECT_GT(taken, 10'000);
}

TEST(KeyPacket, EveryCutIsTruncatedAndEveryAddedByteTrails) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Bytes body = body_of(config_of(seed));
    StreamConfig out;
    for (std::size_t size = 0; size < body.size(); ++size)
      ASSERT_EQ(read_key_body(std::span(body).first(size), out), Status::kTruncated) << size;
    body.push_back(0);
    ASSERT_EQ(read_key_body(body, out), Status::kTrailingBytes);
  }
}

TEST(KeyPacket, AnotherMinorVersionIsRefusedBeforeOneZero) {
  Bytes body = body_of(config_of(1));
  for (const int minor : {0, 2, 255}) {
    body[0] = static_cast<std::uint8_t>(minor);
    StreamConfig out;
    EXPECT_EQ(read_key_body(body, out), Status::kUnsupportedVersion);
  }
}

TEST(KeyPacket, ReservedFlagsAreRefused) {
  for (int bit = 4; bit < 8; ++bit) {
    Bytes body = body_of(config_of(2));
    body[2] |= static_cast<std::uint8_t>(1U << bit);
    StreamConfig out;
    EXPECT_EQ(read_key_body(body, out), Status::kReservedBits) << bit;
  }
}

TEST(KeyPacket, NamesHoldNoZeroByteAndNoMoreThanTheyMay) {
  StreamConfig config = config_of(3);
  config.frame_id = {'c', 'a', 'm'};
  Bytes body = body_of(config);
  StreamConfig out;
  const std::size_t name = body.size() - 4;
  ASSERT_EQ(body[name - 1], 3);
  body[name + 2] = 0;
  EXPECT_EQ(read_key_body(body, out), Status::kFieldRange);
  body[name - 1] = kMaxFrameIdBytes + 1;
  EXPECT_EQ(read_key_body(body, out), Status::kFieldRange);
}

TEST(KeyPacket, AttributeBlocksAreSkippedByTheirLength) {
  const StreamConfig config = config_of(4);
  Bytes body = body_of(config);
  ASSERT_EQ(body.back(), 0);
  body.back() = 2;
  for (const int byte : {9, 3, 0, 1, 2, 3, 200, 0, 0})
    body.push_back(static_cast<std::uint8_t>(byte));
  StreamConfig out;
  ASSERT_EQ(read_key_body(body, out), Status::kOk);
  EXPECT_EQ(out, config);
  for (std::size_t cut = 1; cut <= 9; ++cut)
    EXPECT_EQ(read_key_body(std::span(body).first(body.size() - cut), out), Status::kTruncated);
  body.push_back(0);
  EXPECT_EQ(read_key_body(body, out), Status::kTrailingBytes);
}

TEST(KeyPacket, RandomBytesAreRefusedByName) {
  Pcg32 random(5);
  for (int i = 0; i < 20000; ++i) {
    Bytes body(random.below(300));
    for (auto& b : body) b = static_cast<std::uint8_t>(random.next());
    if (!body.empty() && i % 2 == 0) body[0] = kWireMinor;
    StreamConfig out;
    ASSERT_TRUE(test::is_wire_status(read_key_body(body, out)));
  }
}

TEST(KeyPacket, TheLongestBodyFitsAPacketAndAShortBufferIsRefused) {
  StreamConfig config = config_of(6);
  config.frame_id.fill('x');
  config.frame_id[kMaxFrameIdBytes] = 0;
  EXPECT_EQ(body_of(config).size(), 205U);
  EXPECT_LE(kPacketHeaderBytes + kMaxKeyBodyBytes, 1200U);
  Bytes small(kMaxKeyBodyBytes - 1);
  EXPECT_EQ(write_key_body(config, small), 0U);
}

TEST(KeyPacket, TheHashTellsConfigurationsApart) {
  EXPECT_EQ(key_hash(body_of(config_of(7))), key_hash(body_of(config_of(7))));
  EXPECT_NE(key_hash(body_of(config_of(7))), key_hash(body_of(config_of(8))));
}

}  // namespace
}  // namespace planecast
