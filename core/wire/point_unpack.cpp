#include "core/wire/point_unpack.hpp"

#include <algorithm>

#include "core/wire/decode_io.hpp"
#include "core/wire/packet_header.hpp"
#include "core/wire/point_syntax.hpp"
#include "core/wire/point_tree.hpp"
#include "core/wire/range_decoder.hpp"

namespace planecast {
namespace {

struct CellDecodeIo : DecodeIo {
  const CellAxes& axes;
  std::span<GridPoint> room;
  std::uint32_t used = 0;

  bool bit_at(std::uint32_t probability, bool) noexcept { return coder.bit_at(probability); }
  std::uint32_t octant(std::uint32_t, unsigned) const noexcept { return 0; }
  std::uint32_t count(std::uint32_t) const noexcept { return 0; }

  // `room` holds the points that the head announced; the tree never puts out more.
  Status emit(const std::array<std::uint32_t, 3>& cell, std::uint32_t points) noexcept {
    for (std::size_t i = 0; i < 3; ++i)
      if (cell[i] > axes[i].last()) return Status::kBadSymbol;
    const GridPoint point{axes[0].middle(cell[0]), axes[1].middle(cell[1]),
                          axes[2].middle(cell[2])};
    std::fill_n(room.begin() + used, points, point);
    used += points;
    return Status::kOk;
  }
};

Status unpack_plain(CellDecodeIo& io) noexcept {
  std::array<std::uint32_t, 3> widths{};
  if (const Status status = plain_widths(io, widths); status != Status::kOk) return status;
  for (std::size_t i = 0; i < io.room.size(); ++i) {
    std::array<std::uint32_t, 3> cell{};
    for (std::size_t axis = 0; axis < 3; ++axis)
      cell[axis] = static_cast<std::uint32_t>(plain_number(io, 0, widths[axis]));
    if (io.failed()) return Status::kTruncated;
    if (const Status status = io.emit(cell, 1); status != Status::kOk) return status;
  }
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

void PointFrameUnpacker::layout(Arena& arena, std::uint32_t max_points) noexcept {
  levels_.layout(arena, max_points);
  models_ = arena.take<PointModels>(1);
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
  PointHead head;
  for (CellAxis& axis : head.axes) axis.pitch = pitch_of(cell_half(coding));
  CellDecodeIo io{{coder}, head.axes, target.subspan(used, most - used)};
  const auto kind = static_cast<PointSliceKind>(io.raw(0, 2));
  if (kind != PointSliceKind::kVerbatim && kind != PointSliceKind::kCoded)
    return Status::kFieldRange;
  if (const Status status = point_head(io, head); status != Status::kOk) return status;
  if (io.failed()) return Status::kTruncated;
  if (head.points > io.room.size()) return Status::kTooLarge;
  io.room = io.room.first(head.points);
  Status status = kind == PointSliceKind::kVerbatim ? unpack_plain(io) : unpack_tree(io);
  if (coder.truncated()) status = Status::kTruncated;
  if (status == Status::kOk && coder.trailing()) status = Status::kTrailingBytes;
  if (status == Status::kOk) used += head.points;
  return status;
}

template <class Io>
Status PointFrameUnpacker::unpack_tree(Io& io) noexcept {
  const std::uint32_t depth = io.raw(0, 6), group = io.raw(0, 2);
  if (depth > 32) return Status::kFieldRange;
  models_[0] = trained_point_models();
  mixers_ = trained_point_mixers();
  PointTree<Io> tree(io, models_[0], mixers_, levels_);
  return tree.code(depth, group, static_cast<std::uint32_t>(io.room.size()), 0);
}

}  // namespace planecast
