// The LCM envelope of one codec packet (planecast_packet_t.lcm), written and read by hand.
// lcm-gen's decoder allocates what a hostile count asks for; this one only ever points into its
// input.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/base/status.hpp"

namespace planecast {

/// LCM's fingerprint of planecast_packet_t, as lcm-gen computes it; pinned by a test.
inline constexpr std::uint64_t kEnvelopeFingerprint = 0x269a4663cfb5fba9ULL;

/// Bytes the envelope adds to a packet: fingerprint (8) and size (2).
inline constexpr std::size_t kEnvelopeOverheadBytes = 10;

/// Largest packet an envelope can hold.
inline constexpr std::size_t kMaxPacketBytes = 32767;

/// Largest whole LCM payload used unless the user asks for another: safe below any usual MTU.
inline constexpr std::size_t kDefaultMessageBytes = 1200;

/// Largest packet whose whole LCM payload stays within `message_bytes`, 0 when none does.
constexpr std::size_t max_packet_bytes(std::size_t message_bytes) noexcept {
  if (message_bytes <= kEnvelopeOverheadBytes) return 0;
  const std::size_t packet = message_bytes - kEnvelopeOverheadBytes;
  return packet < kMaxPacketBytes ? packet : kMaxPacketBytes;
}

/// Writes the 10 bytes that stand before a packet of `packet_bytes` (0 .. kMaxPacketBytes) bytes,
/// for a packet that already lies where it is to be sent from. 0 makes a greeting: an envelope
/// without a packet, which a receiver sends itself at start and everybody ignores.
void write_envelope_header(std::size_t packet_bytes,
                           std::span<std::uint8_t, kEnvelopeOverheadBytes> out) noexcept;

/// Writes a whole message into `out` and its length into `size`.
/// kFieldRange: the packet is empty or over kMaxPacketBytes. kTooLarge: `out` is too small.
Status encode_envelope(std::span<const std::uint8_t> packet, std::span<std::uint8_t> out,
                       std::size_t& size) noexcept;

/// Finds the packet inside a message; `packet` then points into `message`, and is empty for a
/// greeting. O(1), reads 10 bytes. kTruncated: shorter than it says. kBadMagic: another LCM type.
/// kFieldRange: a negative size. kTrailingBytes: longer than it says.
Status decode_envelope(std::span<const std::uint8_t> message,
                       std::span<const std::uint8_t>& packet) noexcept;

}  // namespace planecast
