#include "core/wire/point_pack.hpp"

#include <algorithm>

#include "core/wire/encode_io.hpp"
#include "core/wire/packet_header.hpp"
#include "core/wire/point_syntax.hpp"
#include "core/wire/point_tree.hpp"
#include "core/wire/range_encoder.hpp"

namespace planecast {
namespace {

constexpr std::uint32_t kPointBytes = 12;
constexpr std::uint32_t kHeadBytes = (kPointHeadBits + 7) / 8 + 8;  // and the coder's end
constexpr std::size_t kMostSlices = 65535;

struct CellEncodeIo : EncodeIo {
  std::span<const ZKey> cells;

  bool bit_at(std::uint32_t probability, bool value) noexcept {
    coder.bit_at(probability, value);
    return value;
  }
  std::uint32_t octant(std::uint32_t cell, unsigned level) const noexcept {
    return cells[cell].octant(level);
  }
  std::uint32_t count(std::uint32_t cell) const noexcept { return cells[cell].point; }
  Status emit(const std::array<std::uint32_t, 3>&, std::uint32_t) const noexcept {
    return Status::kOk;
  }
};

// Points that fit one slice at 12 bytes each.
std::size_t points_at_worst(std::size_t slice_bytes) noexcept {
  return (slice_bytes - kPacketHeaderBytes - kHeadBytes) / kPointBytes;
}

std::uint32_t points_of(std::span<const ZKey> cells) noexcept {
  std::uint32_t points = 0;
  for (const ZKey& cell : cells) points += cell.point;
  return points;
}

// The head of a slice whose cell 0 is `origin`.
PointHead head_at(const FrameCells& cells, const std::array<std::uint32_t, 3>& origin,
                  std::uint32_t points) noexcept {
  PointHead head{points, cells.own_pitch, cells.axes};
  for (std::size_t i = 0; i < 3; ++i) {
    const std::int32_t middle = cells.axes[i].middle(origin[i]);
    head.axes[i].base = static_cast<std::uint32_t>(middle) ^ 0x80000000U;
  }
  return head;
}

// The box of a growing run of cells.
struct CellBox {
  std::array<std::uint32_t, 3> least{~0U, ~0U, ~0U};
  std::array<std::uint32_t, 3> most{};

  void add(const ZKey& key) noexcept {
    const auto cell = z_cell(key);
    for (std::size_t i = 0; i < 3; ++i) {
      least[i] = std::min(least[i], cell[i]);
      most[i] = std::max(most[i], cell[i]);
    }
  }
  std::array<std::uint32_t, 3> widths() const noexcept {
    std::array<std::uint32_t, 3> widths{};
    for (std::size_t i = 0; i < 3; ++i)
      widths[i] = static_cast<std::uint32_t>(std::bit_width(most[i] - least[i]));
    return widths;
  }
  std::uint32_t point_bits() const noexcept {
    const auto w = widths();
    return w[0] + w[1] + w[2];
  }
};

// Cells from the front of `cells` that a slice of plain numbers of `bytes` holds: one or more.
std::uint32_t plain_fitting(std::span<const ZKey> cells, std::size_t bytes) noexcept {
  CellBox box;
  std::uint64_t points = 0;
  std::uint32_t count = 0;
  for (; count < cells.size(); ++count) {
    box.add(cells[count]);
    points += cells[count].point;
    if (points * box.point_bits() > (bytes - kHeadBytes) * 8) break;
  }
  return count;
}

std::size_t pack_plain(const FrameCells& frame, std::span<const ZKey> cells,
                       std::span<std::uint8_t> room) noexcept {
  CellBox box;
  for (const ZKey& cell : cells) box.add(cell);
  RangeEncoder coder(room);
  CellEncodeIo io{{coder}, cells};
  io.raw(static_cast<std::uint32_t>(PointSliceKind::kVerbatim), 2);
  PointHead head = head_at(frame, box.least, points_of(cells));
  auto widths = box.widths();
  if (point_head(io, head) != Status::kOk || plain_widths(io, widths) != Status::kOk) return 0;
  for (const ZKey& key : cells) {
    const auto cell = z_cell(key);
    for (std::uint32_t i = 0; i < key.point; ++i)
      for (std::size_t axis = 0; axis < 3; ++axis)
        plain_number(io, cell[axis] - box.least[axis], widths[axis]);
  }
  const std::size_t bytes = coder.finish();
  return coder.overflow() ? 0 : bytes;
}

}  // namespace

struct PointFramePacker::Job {
  const PointCoding& coding;
  std::span<const GridPoint> points;
  std::size_t slice_bytes;
  std::span<std::uint8_t> packed;
  std::span<SlicePlace> places;
  FrameReport& report;
};

std::size_t point_frame_capacity(std::uint32_t max_points) noexcept {
  return std::size_t{max_points} * kPointBytes +
         (kPacketHeaderBytes + kHeadBytes) * point_slice_capacity(max_points, kMinPointSliceBytes);
}

// Two slices on end hold more points than one could at worst, else they would be one.
std::size_t point_slice_capacity(std::uint32_t max_points, std::size_t slice_bytes) noexcept {
  if (slice_bytes < kMinPointSliceBytes) return 0;
  const std::size_t by_bytes = 2 * (max_points / points_at_worst(slice_bytes)) + 2;
  return std::min(by_bytes + max_points / kMaxSliceCells, kMostSlices);
}

void seal_slices(const FrameIdentity& identity, std::span<const SlicePlace> places,
                 std::span<std::uint8_t> packed) noexcept {
  for (std::size_t i = 0; i < places.size(); ++i) {
    const PacketHeader header{false,
                              identity.stream,
                              identity.frame & kFrameNumberMask,
                              identity.stamp_offset,
                              static_cast<std::uint16_t>(i),
                              static_cast<std::uint16_t>(places.size()),
                              identity.key_hash};
    seal_packet(header, packed.subspan(places[i].offset, places[i].bytes));
  }
}

void PointFramePacker::layout(Arena& arena, std::uint32_t max_points) noexcept {
  chooser_.layout(arena);
  keys_ = arena.take<ZKey>(max_points);
  spare_ = arena.take<ZKey>(max_points);
  levels_.layout(arena, max_points);
  models_ = arena.take<PointModels>(1);
}

Status PointFramePacker::pack(const PointCoding& coding, std::span<const GridPoint> points,
                              const FrameIdentity& identity, std::size_t slice_bytes,
                              std::span<std::uint8_t> packed, std::span<SlicePlace> places,
                              FrameReport& report) noexcept {
  if (coding.tolerance > kMaxPointTolerance || slice_bytes < kMinPointSliceBytes)
    return Status::kBadConfig;
  if (points.size() > coding.max_points || points.size() > keys_.size())
    return Status::kFrameTooLarge;
  Job job{coding, points, std::min(slice_bytes, kFileSliceBytes), packed, places, report};
  if (const Status status = sort_points(job); status != Status::kOk) return status;
  if (const Status status = pack_slices(job); status != Status::kOk) return status;
  seal_slices(identity, places.first(report.slices), packed);
  return Status::kOk;
}

// Leaves the cells in Z-order in keys_. Every point is checked against its cell's middle, by the
// decoder's arithmetic; the reaches of the axes together are within the tolerance.
Status PointFramePacker::sort_points(Job& job) noexcept {
  cells_ = chooser_.choose(job.coding, job.points);
  std::uint64_t reach = 0;
  for (const std::uint32_t r : cells_.reach) reach += std::uint64_t{r} * r;
  if (reach > std::uint64_t{job.coding.tolerance} * job.coding.tolerance)
    return Status::kBoundExceeded;
  for (std::uint32_t i = 0; i < job.points.size(); ++i) {
    const std::int32_t at[3] = {job.points[i].x, job.points[i].y, job.points[i].z};
    std::array<std::uint32_t, 3> cell{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      cell[axis] = cells_.cell(axis, at[axis]);
      const std::int64_t off = std::int64_t{cells_.axes[axis].middle(cell[axis])} - at[axis];
      if ((off < 0 ? -off : off) > cells_.reach[axis]) return Status::kBoundExceeded;
    }
    keys_[i] = z_key(cell[0], cell[1], cell[2], i);
  }
  const auto keys = keys_.first(job.points.size());
  sort_z_keys(keys, spare_.first(keys.size()));
  cell_count_ = 0;
  for (const ZKey& key : keys) {
    if (cell_count_ > 0 && keys[cell_count_ - 1].same_cell(key)) {
      ++keys[cell_count_ - 1].point;
    } else {
      keys[cell_count_++] = {key.low, key.high, 1};
    }
  }
  return Status::kOk;
}

Status PointFramePacker::pack_slices(Job& job) noexcept {
  std::uint32_t first = 0;
  do {
    std::uint32_t count = 0;
    if (const Status status = pack_some(job, first, count); status != Status::kOk) return status;
    first += count;
  } while (first < cell_count_);
  return Status::kOk;
}

// One slice of cells from `first` on: as many as the measured bits say will fit, fewer when they
// do not; as plain numbers where the tree takes more than those.
Status PointFramePacker::pack_some(Job& job, std::uint32_t first, std::uint32_t& count) noexcept {
  if (job.report.slices >= std::min(job.places.size(), kMostSlices)) return Status::kTooLarge;
  const std::size_t offset = job.report.bytes + kPacketHeaderBytes;
  if (job.packed.size() < offset) return Status::kTooLarge;
  const std::size_t body = job.slice_bytes - kPacketHeaderBytes;
  const auto room = job.packed.subspan(offset, std::min(body, job.packed.size() - offset));
  const auto left = keys_.subspan(first, cell_count_ - first);
  const std::uint32_t most = std::min(static_cast<std::uint32_t>(left.size()), kMaxSliceCells);
  const std::uint32_t plain = std::min(plain_fitting(left, body), most);
  const std::uint64_t likely = std::uint64_t{body} * 8 * 16 * 15 / 16 / cell_bits_q4_;
  count =
      std::clamp(static_cast<std::uint32_t>(std::min<std::uint64_t>(likely, most)), plain, most);
  for (;;) {
    const auto cells = left.first(count);
    // Plain numbers set the upper limit of what a slice may take.
    const std::size_t limit = std::size_t{points_of(cells)} * kPointBytes + kHeadBytes;
    std::size_t bytes = 0;
    if (code_tree(job, cells, room.first(std::min(room.size(), limit)), bytes)) {
      const std::size_t cell_q4 = bytes * 8 * 16 / std::max(count, 1U);
      cell_bits_q4_ = static_cast<std::uint32_t>(std::clamp<std::size_t>(cell_q4, 1, 96 * 16));
      return close_slice(job, cells, bytes);
    }
    if (count <= plain) break;
    count = std::max(plain, count - count / 8 - 1);
  }
  const auto cells = left.first(count);
  const std::size_t bytes = pack_plain(cells_, cells, room);
  return bytes == 0 ? Status::kTooLarge : close_slice(job, cells, bytes);
}

bool PointFramePacker::code_tree(const Job& job, std::span<const ZKey> cells,
                                 std::span<std::uint8_t> room, std::size_t& bytes) noexcept {
  const unsigned depth = cells.empty() ? 0 : z_depth(cells.front(), cells.back());
  std::array<std::uint32_t, 3> origin{};
  if (!cells.empty()) origin = z_cell(cells.front());
  for (std::uint32_t& o : origin) o = depth == 32 ? 0 : o & ~((1U << depth) - 1);
  RangeEncoder coder(room);
  CellEncodeIo io{{coder}, cells};
  io.raw(static_cast<std::uint32_t>(PointSliceKind::kCoded), 2);
  const std::uint32_t points = points_of(cells);
  PointHead head = head_at(cells_, origin, points);
  if (point_head(io, head) != Status::kOk) return false;
  io.raw(depth, 6);
  const unsigned group = job.coding.lossless() ? 0 : 3;
  io.raw(group, 2);
  models_[0] = trained_point_models();
  mixers_ = trained_point_mixers();
  PointTree<CellEncodeIo> tree(io, models_[0], mixers_, levels_);
  const auto count = static_cast<std::uint32_t>(cells.size());
  if (tree.code(depth, group, points, count) != Status::kOk) return false;
  bytes = coder.finish();
  return !coder.overflow();
}

Status PointFramePacker::close_slice(Job& job, std::span<const ZKey> cells,
                                     std::size_t bytes) noexcept {
  const auto total = static_cast<std::uint32_t>(kPacketHeaderBytes + bytes);
  job.places[job.report.slices++] = {static_cast<std::uint32_t>(job.report.bytes), total};
  job.report.bytes += total;
  job.report.points += points_of(cells);
  return Status::kOk;
}

}  // namespace planecast
