#include "transport/envelope.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "core/base/random.hpp"
#include "planecast/planecast_packet_t.hpp"

namespace planecast {
namespace {

std::vector<std::uint8_t> random_bytes(std::size_t size, std::uint64_t seed) {
  Pcg32 random(seed);
  std::vector<std::uint8_t> bytes(size);
  for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random.next());
  return bytes;
}

std::vector<std::uint8_t> encoded(std::span<const std::uint8_t> packet) {
  std::vector<std::uint8_t> message(kEnvelopeOverheadBytes + packet.size());
  std::size_t size = 0;
  EXPECT_EQ(encode_envelope(packet, message, size), Status::kOk);
  message.resize(size);
  return message;
}

std::vector<std::uint8_t> encoded_by_lcm(const std::vector<std::uint8_t>& packet) {
  planecast_packet_t reference;
  reference.payload_size = static_cast<std::int16_t>(packet.size());
  reference.payload = packet;
  std::vector<std::uint8_t> message(static_cast<std::size_t>(reference.getEncodedSize()));
  EXPECT_EQ(reference.encode(message.data(), 0, static_cast<int>(message.size())),
            static_cast<int>(message.size()));
  return message;
}

}  // namespace

TEST(Envelope, FingerprintIsTheOneLcmGenComputes) {
  EXPECT_EQ(static_cast<std::uint64_t>(planecast::planecast_packet_t::getHash()),
            kEnvelopeFingerprint);
}

TEST(Envelope, BytesEqualLcmGensForEverySizeClass) {
  for (const std::size_t size : {1UL, 2UL, 255UL, 256UL, 1190UL, 1440UL, 32767UL}) {
    const std::vector<std::uint8_t> packet = random_bytes(size, size);
    EXPECT_EQ(encoded(packet), encoded_by_lcm(packet)) << size;
  }
}

TEST(Envelope, LcmGensBytesAreReadBack) {
  const std::vector<std::uint8_t> packet = random_bytes(700, 1);
  const std::vector<std::uint8_t> message = encoded_by_lcm(packet);
  std::span<const std::uint8_t> found;
  ASSERT_EQ(decode_envelope(message, found), Status::kOk);
  EXPECT_EQ(std::vector<std::uint8_t>(found.begin(), found.end()), packet);
  EXPECT_EQ(found.data(), message.data() + kEnvelopeOverheadBytes);
}

TEST(Envelope, DefaultMessageStaysWithin1200Bytes) {
  const std::vector<std::uint8_t> packet = random_bytes(max_packet_bytes(kDefaultMessageBytes), 2);
  EXPECT_EQ(packet.size(), 1190U);
  EXPECT_EQ(encoded(packet).size(), 1200U);
  EXPECT_EQ(max_packet_bytes(10), 0U);
  EXPECT_EQ(max_packet_bytes(70'000), kMaxPacketBytes);
}

TEST(Envelope, RefusesPacketsItCannotHold) {
  std::vector<std::uint8_t> out(40'000);
  std::size_t size = 1;
  EXPECT_EQ(encode_envelope({}, out, size), Status::kFieldRange);
  EXPECT_EQ(size, 0U);
  EXPECT_EQ(encode_envelope(random_bytes(32'768, 3), out, size), Status::kFieldRange);
  EXPECT_EQ(encode_envelope(random_bytes(50, 3), std::span(out).first(59), size),
            Status::kTooLarge);
}

TEST(Envelope, EveryTruncationAndExtensionIsRefused) {
  const std::vector<std::uint8_t> message = encoded(random_bytes(64, 4));
  std::span<const std::uint8_t> found;
  for (std::size_t size = 0; size < message.size(); ++size) {
    // A heap block of exactly this size lets AddressSanitizer see any read past it.
    const std::vector<std::uint8_t> cut(message.begin(),
                                        message.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_EQ(decode_envelope(cut, found), Status::kTruncated) << size;
    EXPECT_TRUE(found.empty());
  }
  std::vector<std::uint8_t> longer = message;
  longer.push_back(0);
  EXPECT_EQ(decode_envelope(longer, found), Status::kTrailingBytes);
}

TEST(Envelope, EveryBitFlipOfTheHeaderIsRefusedAndOfThePayloadIsNot) {
  const std::vector<std::uint8_t> message = encoded(random_bytes(64, 5));
  for (std::size_t bit = 0; bit < message.size() * 8; ++bit) {
    std::vector<std::uint8_t> flipped = message;
    flipped[bit / 8] = static_cast<std::uint8_t>(flipped[bit / 8] ^ (1U << (bit % 8)));
    std::span<const std::uint8_t> found;
    const Status status = decode_envelope(flipped, found);
    if (bit < 64) {
      EXPECT_EQ(status, Status::kBadMagic) << bit;
    } else if (bit < 80) {
      EXPECT_NE(status, Status::kOk) << bit;
      EXPECT_TRUE(found.empty());
    } else {
      EXPECT_EQ(status, Status::kOk) << bit;  // the packet's own check finds these
    }
  }
}

TEST(Envelope, AGreetingIsAnEmptyEnvelopeThatLcmGenReadsToo) {
  std::array<std::uint8_t, kEnvelopeOverheadBytes> message{};
  write_envelope_header(0, message);
  std::span<const std::uint8_t> found;
  EXPECT_EQ(decode_envelope(message, found), Status::kOk);
  EXPECT_TRUE(found.empty());
  planecast_packet_t reference;
  EXPECT_EQ(reference.decode(message.data(), 0, static_cast<int>(message.size())), 10);
  EXPECT_EQ(reference.payload_size, 0);
}

}  // namespace planecast
