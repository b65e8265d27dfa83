// What transport needs to know of a packet, and the function that reads it from the codec's header.
// Transport never parses the codec's bytes itself: the caller supplies the parser.
#pragma once

#include <cstdint>
#include <span>

#include "core/base/status.hpp"

namespace planecast {

/// The identity of one packet within its stream.
struct PacketInfo {
  std::uint32_t session = 0;      ///< random per start of the sender
  std::uint16_t stream = 0;       ///< which sensor
  std::uint32_t frame = 0;        ///< counts by one, wraps at 2^frame_bits of the assembler
  std::uint16_t slice = 0;        ///< 0 .. slice_count - 1; not used for a key packet
  std::uint16_t slice_count = 0;  ///< slices of the frame, at least 1; not used for a key packet
  bool key = false;               ///< a key packet: it belongs to `frame` but is none of its slices
  std::int64_t stamp_ns = 0;      ///< time of capture on the sender's clock
};

/// Checks a packet's header and integrity and fills `out`.
/// Called on the receiving thread, once a packet; must not block, allocate or throw, and must
/// accept any bytes. kBadMagic, kUnsupportedVersion and kBadCheck are counted by name, every other
/// failure as malformed.
using ParseFn = Status (*)(std::span<const std::uint8_t> packet, PacketInfo& out) noexcept;

/// Signed distance from frame number `from` to `to`, right across the wrap at 2^bits (16..32). Bits
/// above are ignored.
inline std::int32_t frame_distance(std::uint32_t from, std::uint32_t to,
                                   unsigned bits = 32) noexcept {
  const unsigned unused = 32 - bits;
  return static_cast<std::int32_t>((to - from) << unused) >> unused;
}

}  // namespace planecast
