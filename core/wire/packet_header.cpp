#include "core/wire/packet_header.hpp"

#include "core/base/bytes.hpp"
#include "core/base/crc32c.hpp"

namespace planecast {
namespace {

constexpr std::uint8_t kMagic = 0xc0;    // high nibble; the low nibble is the major version
constexpr std::uint8_t kKeyFlag = 0x01;  // flags; the other bits are reserved
constexpr std::size_t kCheckAt = 20;

std::uint32_t check_of(std::span<const std::uint8_t> packet) noexcept {
  const std::uint32_t front = crc32c(packet.first(kCheckAt));
  return crc32c(packet.subspan(kPacketHeaderBytes), front);
}

}  // namespace

void seal_packet(const PacketHeader& header, std::span<std::uint8_t> packet) noexcept {
  std::uint8_t* p = packet.data();
  p[0] = kMagic | kWireMajor;
  p[1] = header.key ? kKeyFlag : std::uint8_t{0};
  p[2] = header.stream;
  for (int i = 0; i < 3; ++i) p[3 + i] = static_cast<std::uint8_t>(header.frame >> (8 * i));
  for (int i = 0; i < 6; ++i) p[6 + i] = static_cast<std::uint8_t>(header.stamp_offset >> (8 * i));
  store_le<std::uint16_t>(p + 12, header.slice);
  store_le<std::uint16_t>(p + 14, header.slice_count);
  store_le<std::uint32_t>(p + 16, header.key_hash);
  store_le<std::uint32_t>(p + kCheckAt, check_of(packet));
}

Status open_packet(std::span<const std::uint8_t> packet, PacketHeader& header) noexcept {
  if (packet.size() < kPacketHeaderBytes) return Status::kTruncated;
  const std::uint8_t* p = packet.data();
  if ((p[0] & 0xf0U) != kMagic) return Status::kBadMagic;
  if ((p[0] & 0x0fU) != kWireMajor) return Status::kUnsupportedVersion;
  if (load_le<std::uint32_t>(p + kCheckAt) != check_of(packet)) return Status::kBadCheck;
  if ((p[1] & ~kKeyFlag) != 0) return Status::kReservedBits;
  header.key = (p[1] & kKeyFlag) != 0;
  header.stream = p[2];
  header.frame = 0;
  for (int i = 0; i < 3; ++i) header.frame |= std::uint32_t{p[3 + i]} << (8 * i);
  header.stamp_offset = 0;
  for (int i = 0; i < 6; ++i) header.stamp_offset |= std::uint64_t{p[6 + i]} << (8 * i);
  header.slice = load_le<std::uint16_t>(p + 12);
  header.slice_count = load_le<std::uint16_t>(p + 14);
  header.key_hash = load_le<std::uint32_t>(p + 16);
  if (header.key)
    return header.slice == 0 && header.slice_count == 0 ? Status::kOk : Status::kFieldRange;
  return header.slice < header.slice_count ? Status::kOk : Status::kFieldRange;
}

}  // namespace planecast
