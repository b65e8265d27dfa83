#include "core/wire/frame_pack.hpp"

#include <algorithm>
#include <cstdlib>

namespace planecast {
namespace {

constexpr std::uint32_t kTileHeadBits = 120;
constexpr std::uint32_t kReadingCost = 3;  // all costs in 1/16 bit
constexpr std::uint32_t kCorrectionCost = 56;
constexpr std::uint32_t kMixedCost = 5;

std::uint32_t ceil_blocks(std::uint32_t pixels) noexcept {
  return (pixels + 7) / 8;
}

// Estimated cost of a block in 1/16 bit: readings whose neighbours do not predict them within the
// bound, and the hole mask where a block is mixed.
std::uint32_t block_cost(const CodingTables& tables, const FrameModel& frame, std::uint32_t bx,
                         std::uint32_t by) noexcept {
  const CameraModel& camera = tables.config->camera;
  const std::uint32_t u1 = std::min<std::uint32_t>(bx * 8 + 8, camera.width);
  const std::uint32_t v1 = std::min<std::uint32_t>(by * 8 + 8, camera.height);
  const std::uint8_t ray_class = tables.bounds->ray_class(bx, by);
  std::uint32_t readings = 0, corrections = 0, pixels = 0;
  for (std::uint32_t v = by * 8; v < v1; ++v) {
    const std::uint16_t* row = &frame.depth[std::size_t{v} * camera.width];
    const std::uint16_t* above = v > 0 ? row - camera.width : row;
    for (std::uint32_t u = bx * 8; u < u1; ++u) {
      ++pixels;
      if (row[u] == 0) continue;
      ++readings;
      const int left = u > 0 ? row[u - 1] : 0;
      const int expected = left != 0 && above[u] != 0 ? (left + above[u]) / 2 : left + above[u];
      const auto error = static_cast<std::uint32_t>(std::abs(int{row[u]} - expected));
      corrections += error > tables.bounds->max_error(row[u], ray_class);
    }
  }
  if (readings == 0) return 2;
  return 24 + readings * kReadingCost + corrections * kCorrectionCost +
         (readings < pixels ? pixels * kMixedCost : 0);
}

}  // namespace

struct FramePacker::Job {
  const CodingTables& tables;
  const FrameModel& frame;
  const FrameIdentity& identity;
  std::size_t slice_bytes;
  std::span<std::uint8_t> out;
  std::span<SlicePlace> places;
  FrameReport& report;
  std::uint64_t estimated_bits = 0;
};

std::size_t frame_capacity(std::uint32_t width, std::uint32_t height) noexcept {
  const std::size_t blocks = std::size_t{ceil_blocks(width)} * ceil_blocks(height);
  return blocks * (64 * 2 + 8 + kPacketHeaderBytes) + kMinSliceBytes;
}

std::size_t slice_capacity(std::uint32_t width, std::uint32_t height) noexcept {
  return std::min<std::size_t>(std::size_t{ceil_blocks(width)} * ceil_blocks(height), 65535);
}

void FramePacker::layout(Arena& arena, std::uint32_t max_width, std::uint32_t max_height) noexcept {
  tiles_.layout(arena, max_width);
  cost_sums_ = arena.take<std::uint32_t>((std::size_t{ceil_blocks(max_width)} + 1) *
                                         (ceil_blocks(max_height) + 1));
}

Status FramePacker::pack(const CodingTables& tables, const FrameModel& frame,
                         const FrameIdentity& identity, std::size_t slice_bytes,
                         std::span<std::uint8_t> out, std::span<SlicePlace> places,
                         FrameReport& report) noexcept {
  if (slice_bytes < kMinSliceBytes) return Status::kBadConfig;
  report = {};
  report.surfaces = static_cast<std::uint32_t>(frame.surfaces.size());
  Job job{tables, frame, identity, slice_bytes, out, places, report, 0};
  estimate_costs(tables, frame);
  const CameraModel& camera = tables.config->camera;
  const TileRect whole{0, 0, blocks_wide(camera), blocks_high(camera)};
  const Status status = pack_rect(job, whole);
  if (status != Status::kOk) return status;
  for (std::uint32_t i = 0; i < report.slices; ++i) {
    PacketHeader header{false,
                        identity.stream,
                        identity.frame & kFrameNumberMask,
                        identity.stamp_offset,
                        static_cast<std::uint16_t>(i),
                        static_cast<std::uint16_t>(report.slices),
                        identity.key_hash};
    seal_packet(header, out.subspan(places[i].offset, places[i].bytes));
  }
  if (job.estimated_bits > 0) {
    const std::uint64_t measured = std::uint64_t{report.bytes} * 8 * 256 / job.estimated_bits;
    scale_q8_ = static_cast<std::uint32_t>(
        std::clamp<std::uint64_t>((scale_q8_ * 3 + measured) / 4, 16, 4096));
  }
  return Status::kOk;
}

void FramePacker::estimate_costs(const CodingTables& tables, const FrameModel& frame) noexcept {
  const std::uint32_t wide = blocks_wide(tables.config->camera);
  const std::uint32_t high = blocks_high(tables.config->camera);
  std::fill_n(cost_sums_.begin(), wide + 1, 0U);
  for (std::uint32_t by = 0; by < high; ++by) {
    std::uint32_t row = 0;
    const std::uint32_t* above = &cost_sums_[std::size_t{by} * (wide + 1)];
    std::uint32_t* sums = &cost_sums_[std::size_t{by + 1} * (wide + 1)];
    sums[0] = 0;
    for (std::uint32_t bx = 0; bx < wide; ++bx) {
      row += block_cost(tables, frame, bx, by);
      sums[bx + 1] = above[bx + 1] + row;
    }
  }
}

std::uint64_t FramePacker::estimate(const Job& job, const TileRect& r) const noexcept {
  const std::size_t stride = std::size_t{blocks_wide(job.tables.config->camera)} + 1;
  const auto at = [&](std::uint32_t bx, std::uint32_t by) { return cost_sums_[by * stride + bx]; };
  const std::uint32_t sum =
      at(r.bx + r.bw, r.by + r.bh) - at(r.bx, r.by + r.bh) - at(r.bx + r.bw, r.by) + at(r.bx, r.by);
  return kTileHeadBits + (std::uint64_t{sum} * scale_q8_ >> 12U);
}

Status FramePacker::pack_rect(Job& job, const TileRect& rect) noexcept {
  const bool fits_syntax = rect.bw <= kMaxTileBlocks && rect.bh <= kMaxTileBlocks;
  const std::size_t body = job.slice_bytes - kPacketHeaderBytes;
  const bool likely = estimate(job, rect) <= std::uint64_t{body} * 8 * 15 / 16;
  const bool single = rect.bw == 1 && rect.bh == 1;
  if (!fits_syntax || (!likely && !single)) return pack_halves(job, rect);

  if (job.report.slices >= job.places.size()) return Status::kTooLarge;
  const std::size_t offset = job.report.bytes;
  if (job.out.size() < offset + kPacketHeaderBytes) return Status::kTooLarge;
  const std::size_t room = std::min(body, job.out.size() - offset - kPacketHeaderBytes);
  TileReport tile;
  const Status status = tiles_.pack(job.tables, job.frame, rect,
                                    job.out.subspan(offset + kPacketHeaderBytes, room), tile);
  if (status == Status::kTooLarge && !single) return pack_halves(job, rect);
  if (status != Status::kOk) return status;
  const auto bytes = static_cast<std::uint32_t>(kPacketHeaderBytes + tile.bytes);
  job.places[job.report.slices++] = {static_cast<std::uint32_t>(offset), bytes};
  job.report.bytes += bytes;
  job.report.points += tile.points;
  job.report.corrections += tile.corrections;
  job.estimated_bits += estimate(job, rect) * 256 / scale_q8_;
  return Status::kOk;
}

// Splits across the longer side, where the estimated cost halves.
Status FramePacker::pack_halves(Job& job, const TileRect& rect) noexcept {
  TileRect first = rect, second = rect;
  const bool wide = rect.bw >= rect.bh;
  const std::uint32_t side = wide ? rect.bw : rect.bh;
  const std::uint64_t half = (estimate(job, rect) - kTileHeadBits) / 2;
  // Near-square tiles predict best: the cut stays in the middle half.
  std::uint32_t cut = std::max(1U, side / 4);
  for (; cut < side - side / 4 && cut < side - 1; ++cut) {
    TileRect part = rect;
    (wide ? part.bw : part.bh) = cut;
    if (estimate(job, part) - kTileHeadBits >= half) break;
  }
  (wide ? first.bw : first.bh) = cut;
  (wide ? second.bx : second.by) += cut;
  (wide ? second.bw : second.bh) = side - cut;
  const Status status = pack_rect(job, first);
  return status == Status::kOk ? pack_rect(job, second) : status;
}

}  // namespace planecast
