#include "apps/common/packet_parse.hpp"

namespace planecast {

Status parse_planecast_packet(std::span<const std::uint8_t> packet, PacketInfo& out) noexcept {
  PacketHeader header;
  if (const Status status = open_packet(packet, header); status != Status::kOk) return status;
  out.session = header.key_hash;
  out.stream = header.stream;
  out.frame = header.frame;
  out.slice = header.slice;
  out.slice_count = header.slice_count;
  out.key = header.key;
  out.stamp_ns = static_cast<std::int64_t>(header.stamp_offset);
  return Status::kOk;
}

std::int64_t stamp_of_offset(std::int64_t epoch_ns, std::int64_t offset_ns,
                             std::int64_t near_ns) noexcept {
  constexpr unsigned kUnusedBits = 16;  // of 64, above the offset's 48
  const auto known = static_cast<std::uint64_t>(epoch_ns) + static_cast<std::uint64_t>(offset_ns);
  const std::uint64_t apart = (known - static_cast<std::uint64_t>(near_ns)) << kUnusedBits;
  // Shifted back with its sign: the distance modulo 2^48 of smallest size.
  const std::int64_t distance = static_cast<std::int64_t>(apart) >> kUnusedBits;
  return static_cast<std::int64_t>(static_cast<std::uint64_t>(near_ns) +
                                   static_cast<std::uint64_t>(distance));
}

}  // namespace planecast
