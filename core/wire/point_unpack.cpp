#include "core/wire/point_unpack.hpp"

#include <algorithm>

#include "core/wire/packet_header.hpp"
#include "core/wire/point_syntax.hpp"
#include "core/wire/range_decoder.hpp"

namespace planecast {
namespace {

struct DecodeIo {
  RangeDecoder& coder;
  std::uint32_t raw(std::uint32_t, int bits) noexcept { return coder.raw(bits); }
};

Status unpack_verbatim(DecodeIo& io, std::uint32_t half, std::span<GridPoint> room,
                       std::uint32_t& count) noexcept {
  const std::uint32_t points = plain_number(io, 0, 32);
  if (points > room.size()) return Status::kTooLarge;
  CellBox box;
  if (const Status status = plain_box(io, box); status != Status::kOk) return status;
  const std::uint32_t last = cell_of(std::numeric_limits<std::int32_t>::max(), half);
  for (std::uint32_t i = 0; i < points; ++i) {
    std::array<std::uint32_t, 3> cell{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::uint32_t up = plain_number(io, 0, box.bits[axis]);
      if (box.least[axis] > last || up > last - box.least[axis]) return Status::kBadSymbol;
      cell[axis] = box.least[axis] + up;
    }
    if (io.coder.truncated()) return Status::kTruncated;
    room[i] = {cell_middle(cell[0], half), cell_middle(cell[1], half), cell_middle(cell[2], half)};
  }
  count = points;
  return Status::kOk;
}

}  // namespace

Status point_slice_kind(std::span<const std::uint8_t> packet, PointSliceKind& kind) noexcept {
  if (packet.size() <= kPacketHeaderBytes) return Status::kTruncated;
  RangeDecoder coder(packet.subspan(kPacketHeaderBytes));
  const std::uint32_t bits = coder.raw(2);
  if (bits > static_cast<std::uint32_t>(PointSliceKind::kPatches)) return Status::kFieldRange;
  kind = static_cast<PointSliceKind>(bits);
  return Status::kOk;
}

void PointFrameUnpacker::layout(Arena&, std::uint32_t max_points) noexcept {
  max_points_ = max_points;
}

Status PointFrameUnpacker::unpack_slice(const PointCoding& coding, std::uint32_t key_hash,
                                        std::span<const std::uint8_t> packet,
                                        std::span<GridPoint> target, std::uint32_t& used) noexcept {
  PacketHeader header;
  if (const Status status = open_packet(packet, header); status != Status::kOk) return status;
  if (header.key) return Status::kFieldRange;
  if (header.key_hash != key_hash) return Status::kUnknownKey;
  if (coding.tolerance > kMaxPointTolerance) return Status::kBadConfig;
  const std::size_t most = std::min<std::size_t>(target.size(), coding.max_points);
  if (used > most) return Status::kTooLarge;

  RangeDecoder coder(packet.subspan(kPacketHeaderBytes));
  DecodeIo io{coder};
  const std::uint32_t kind = io.raw(0, 2);
  if (kind != static_cast<std::uint32_t>(PointSliceKind::kVerbatim)) return Status::kFieldRange;
  std::uint32_t count = 0;
  const Status status =
      unpack_verbatim(io, cell_half(coding), target.subspan(used, most - used), count);
  if (coder.truncated()) return Status::kTruncated;
  if (status != Status::kOk) return status;
  if (coder.trailing()) return Status::kTrailingBytes;
  used += count;
  return Status::kOk;
}

}  // namespace planecast
