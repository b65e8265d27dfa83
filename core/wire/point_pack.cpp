#include "core/wire/point_pack.hpp"

#include <algorithm>

#include "core/wire/packet_header.hpp"
#include "core/wire/point_syntax.hpp"
#include "core/wire/range_encoder.hpp"

namespace planecast {
namespace {

constexpr std::uint32_t kPointBytes = 12;
constexpr std::uint32_t kHeadBytes = (kPlainHeadBits + 7) / 8 + 8;  // and the coder's end
constexpr std::size_t kMostSlices = 65535;

struct EncodeIo {
  RangeEncoder& coder;
  std::uint32_t raw(std::uint32_t value, int bits) noexcept {
    coder.raw(value, bits);
    return value;
  }
};

// Points that fit one slice at 12 bytes each.
std::size_t points_at_worst(std::size_t slice_bytes) noexcept {
  return (slice_bytes - kPacketHeaderBytes - kHeadBytes) / kPointBytes;
}

// Grows `box` by a cell; the widths come at the end.
struct BoxGrowth {
  std::array<std::uint32_t, 3> least{~0U, ~0U, ~0U};
  std::array<std::uint32_t, 3> most{};

  void add(const std::array<std::uint32_t, 3>& cell) noexcept {
    for (std::size_t i = 0; i < 3; ++i) {
      least[i] = std::min(least[i], cell[i]);
      most[i] = std::max(most[i], cell[i]);
    }
  }
  CellBox box() const noexcept {
    CellBox box;
    for (std::size_t i = 0; i < 3 && least[i] <= most[i]; ++i) {
      box.least[i] = least[i];
      box.bits[i] = static_cast<std::uint32_t>(std::bit_width(most[i] - least[i]));
    }
    return box;
  }
};

}  // namespace

struct PointFramePacker::Job {
  std::uint32_t half;
  std::span<const GridPoint> points;
  std::size_t slice_bytes;
  std::span<std::uint8_t> packed;
  std::span<SlicePlace> places;
  FrameReport& report;

  std::array<std::uint32_t, 3> cell(std::uint32_t point) const noexcept {
    const GridPoint& p = points[point];
    return {cell_of(p.x, half), cell_of(p.y, half), cell_of(p.z, half)};
  }
};

std::size_t point_frame_capacity(std::uint32_t max_points) noexcept {
  const std::size_t slices = max_points / points_at_worst(kMinPointSliceBytes) + 1;
  return std::size_t{max_points} * kPointBytes + slices * (kPacketHeaderBytes + kHeadBytes);
}

std::size_t point_slice_capacity(std::uint32_t max_points, std::size_t slice_bytes) noexcept {
  if (slice_bytes < kMinPointSliceBytes) return 0;
  return std::min(max_points / points_at_worst(slice_bytes) + 1, kMostSlices);
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
  keys_ = arena.take<ZKey>(max_points);
  spare_ = arena.take<ZKey>(max_points);
}

Status PointFramePacker::pack(const PointCoding& coding, std::span<const GridPoint> points,
                              const FrameIdentity& identity, std::size_t slice_bytes,
                              std::span<std::uint8_t> packed, std::span<SlicePlace> places,
                              FrameReport& report) noexcept {
  if (coding.tolerance > kMaxPointTolerance || slice_bytes < kMinPointSliceBytes)
    return Status::kBadConfig;
  if (points.size() > coding.max_points || points.size() > keys_.size())
    return Status::kFrameTooLarge;
  Job job{cell_half(coding), points, slice_bytes, packed, places, report};
  sort_points(job);
  if (const Status status = pack_slices(job); status != Status::kOk) return status;
  seal_slices(identity, places.first(report.slices), packed);
  return Status::kOk;
}

void PointFramePacker::sort_points(const Job& job) noexcept {
  for (std::uint32_t i = 0; i < job.points.size(); ++i) {
    const auto cell = job.cell(i);
    keys_[i] = z_key(cell[0], cell[1], cell[2], i);
  }
  sort_z_keys(keys_.first(job.points.size()), spare_.first(job.points.size()));
}

Status PointFramePacker::pack_slices(Job& job) noexcept {
  const auto total = static_cast<std::uint32_t>(job.points.size());
  const std::size_t body =
      std::min(job.slice_bytes, kFileSliceBytes) - kPacketHeaderBytes - kHeadBytes;
  std::uint32_t first = 0;
  do {
    const std::uint32_t count = fitting(job, first, body);
    if (const Status status = pack_verbatim(job, first, count); status != Status::kOk)
      return status;
    first += count;
  } while (first < total);
  return Status::kOk;
}

// Points from `first` on that a slice of plain numbers of `body` bytes holds.
std::uint32_t PointFramePacker::fitting(const Job& job, std::uint32_t first,
                                        std::size_t body) const noexcept {
  const auto total = static_cast<std::uint32_t>(job.points.size());
  BoxGrowth growth;
  std::uint32_t count = 0;
  for (; first + count < total; ++count) {
    growth.add(job.cell(keys_[first + count].point));
    if (std::uint64_t{count + 1} * growth.box().point_bits() > body * 8) break;
  }
  return count;
}

Status PointFramePacker::pack_verbatim(Job& job, std::uint32_t first,
                                       std::uint32_t count) noexcept {
  if (job.report.slices >= std::min(job.places.size(), kMostSlices)) return Status::kTooLarge;
  const std::size_t offset = job.report.bytes + kPacketHeaderBytes;
  if (job.packed.size() < offset) return Status::kTooLarge;
  BoxGrowth growth;
  for (std::uint32_t i = 0; i < count; ++i) growth.add(job.cell(keys_[first + i].point));
  CellBox box = growth.box();

  const std::size_t room =
      std::min(job.slice_bytes - kPacketHeaderBytes, job.packed.size() - offset);
  RangeEncoder coder(job.packed.subspan(offset, room));
  EncodeIo io{coder};
  io.raw(static_cast<std::uint32_t>(PointSliceKind::kVerbatim), 2);
  plain_number(io, count, 32);
  if (const Status status = plain_box(io, box); status != Status::kOk) return status;
  for (std::uint32_t i = 0; i < count; ++i) {
    const auto cell = job.cell(keys_[first + i].point);
    for (std::size_t axis = 0; axis < 3; ++axis)
      plain_number(io, cell[axis] - box.least[axis], box.bits[axis]);
  }
  const std::size_t bytes = kPacketHeaderBytes + coder.finish();
  if (coder.overflow()) return Status::kTooLarge;
  job.places[job.report.slices++] = {static_cast<std::uint32_t>(job.report.bytes),
                                     static_cast<std::uint32_t>(bytes)};
  job.report.bytes += bytes;
  job.report.points += count;
  return Status::kOk;
}

}  // namespace planecast
