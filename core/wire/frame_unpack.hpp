// Decodes the slices of a frame into a depth image (docs/wire-format.md, "Frame"). Decoder half.
#pragma once

#include <cstdint>
#include <span>

#include "core/base/arena.hpp"
#include "core/base/status.hpp"
#include "core/wire/packet_header.hpp"
#include "core/wire/tile_unpack.hpp"

namespace planecast {

/// Decodes slices one by one, in any order; slices that never come leave zeros.
class FrameUnpacker {
 public:
  void layout(Arena& arena, std::uint32_t max_width) noexcept { tiles_.layout(arena, max_width); }

  /// Decodes one sealed slice into `target`. kUnknownKey when the slice was coded under another
  /// key packet; otherwise the Statuses of open_packet and TileUnpacker::unpack.
  Status unpack_slice(const CodingTables& tables, std::uint32_t key_hash,
                      std::span<const std::uint8_t> packet, const TileTarget& target,
                      TileContent& content) noexcept {
    PacketHeader header;
    if (const Status status = open_packet(packet, header); status != Status::kOk) return status;
    if (header.key) return Status::kFieldRange;
    if (header.key_hash != key_hash) return Status::kUnknownKey;
    return tiles_.unpack(tables, packet.subspan(kPacketHeaderBytes), target, content);
  }

  /// The rectangle that a sealed slice will fill when it decodes. Statuses as unpack_slice.
  /// O(bytes).
  static Status peek(const CodingTables& tables, std::uint32_t key_hash,
                     std::span<const std::uint8_t> packet, TileRect& rect) noexcept {
    PacketHeader header;
    if (const Status status = open_packet(packet, header); status != Status::kOk) return status;
    if (header.key) return Status::kFieldRange;
    if (header.key_hash != key_hash) return Status::kUnknownKey;
    return TileUnpacker::peek(tables.config->camera, packet.subspan(kPacketHeaderBytes), rect);
  }

 private:
  TileUnpacker tiles_;
};

}  // namespace planecast
