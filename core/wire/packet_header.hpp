// The 24 bytes at the front of every packet, slice or key (docs/wire-format.md, "Packet header").
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/base/status.hpp"

namespace planecast {

inline constexpr std::size_t kPacketHeaderBytes = 24;
inline constexpr std::uint8_t kWireMajor = 0;
inline constexpr std::uint8_t kWireMinor = 1;
/// Frame numbers on the wire have 24 bits and wrap.
inline constexpr std::uint32_t kFrameNumberMask = 0xffffffU;

/// What a header says. key_hash: CRC-32C of the key packet's body that slices need; for a key
/// packet, of its own body.
struct PacketHeader {
  bool key = false;
  std::uint8_t stream = 0;
  std::uint32_t frame = 0;         ///< modulo 2^24
  std::uint64_t stamp_offset = 0;  ///< [ns] since the key packet's epoch, modulo 2^48
  std::uint16_t slice = 0;         ///< 0 .. slice_count-1; 0 in a key packet
  std::uint16_t slice_count = 0;   ///< 1 .. 65535; 0 in a key packet
  std::uint32_t key_hash = 0;

  friend bool operator==(const PacketHeader&, const PacketHeader&) = default;
};

/// Writes the header over packet[0..24) and the check over the whole packet. `packet` holds the
/// body already and is at least kPacketHeaderBytes long.
void seal_packet(const PacketHeader& header, std::span<std::uint8_t> packet) noexcept;

/// Reads and checks a header and the packet's check. kTruncated: shorter than a header; kBadMagic;
/// kUnsupportedVersion; kReservedBits; kFieldRange: slice not below slice_count; kBadCheck.
/// Any bytes, any thread; no allocation.
Status open_packet(std::span<const std::uint8_t> packet, PacketHeader& header) noexcept;

}  // namespace planecast
