// Columns of tiles that end where their slices are full.
#include <algorithm>
#include <array>

#include "core/wire/column_plan.hpp"
#include "core/wire/frame_pack_job.hpp"

namespace planecast {
namespace {

constexpr double kColumnFill = 7.6;  // bits planned for each byte of a slice, on average

}  // namespace

// Cuts the frame into columns, and these into parts.
void FramePacker::plan_parts(Job& job) const noexcept {
  const CameraModel& camera = job.tables.config->camera;
  const std::uint32_t wide = blocks_wide(camera), high = blocks_high(camera);
  std::uint32_t parts = 1;
  job.plan.count = 0;
  if (!job.one_slice) {
    const double slice_bits =
        static_cast<double>(job.slice_bytes - kPacketHeaderBytes) * kColumnFill - kTileHeadBits;
    plan_columns(
        wide, high, slice_bits,
        [&](std::uint32_t x0, std::uint32_t x1) {
          return estimate(job, {x0, 0, x1 - x0, high});
        },
        job.plan);
    // A deadline is kept by looking back at the whole frame so far.
    if (job.deadline.clock == nullptr) parts = std::min(job.plan.count, kMaxFrameParts);
  }
  for (std::uint32_t i = 0; i < parts; ++i) {
    Part& part = (*job.parts)[i];
    part = {};
    part.job = &job;
    part.column = job.plan.count * i / parts;
    part.columns = job.plan.count * (i + 1) / parts - part.column;
    const std::uint32_t x0 = job.plan.start[part.column];
    const std::uint32_t x1 = part.columns > 0 ? job.plan.start[part.column + part.columns] : wide;
    part.rect = {x0, 0, x1 - x0, high};
  }
  job.part_count = parts;
}

Status FramePacker::pack_part(Part& part) noexcept {
  if (part.columns == 0) return pack_rect(part, part.rect);
  const ColumnPlan& plan = part.job->plan;
  for (std::uint32_t i = part.column; i < part.column + part.columns; ++i) {
    const TileRect column{plan.start[i], 0, plan.width(i), part.rect.bh};
    if (const Status status = pack_column(part, column); status != Status::kOk) return status;
  }
  return Status::kOk;
}

// Tiles from the top down, each as high as fills its slice.
Status FramePacker::pack_column(Part& part, TileRect rest) noexcept {
  const Job& job = *part.job;
  const double room = static_cast<double>(job.slice_bytes - kPacketHeaderBytes) * 8;
  std::array<float, kMaxTileBlocks> row_bits;
  while (rest.bh > 0) {
    TileRect tile = {rest.bx, rest.by, rest.bw, 0};
    TileFill fill;
    double bits = kTileHeadBits;
    // Some rows more than fit by the estimate: it errs.
    while (tile.bh < std::min(rest.bh, kMaxTileBlocks) && bits < 1.5 * room) {
      const double row = estimate(job, {rest.bx, rest.by + tile.bh, rest.bw, 1});
      row_bits[tile.bh++] = static_cast<float>(row);
      bits += row;
      if (bits <= room || tile.bh == 1) fill.planned = tile.bh;
    }
    fill.row_bits = std::span(row_bits).first(tile.bh);
    TileRect planned = tile;
    planned.bh = fill.planned;
    std::uint32_t rows = planned.bh;
    if (too_late(part, planned)) {
      if (const Status status = pack_rect(part, planned); status != Status::kOk) return status;
    } else {
      TileReport report;
      const Status status = pack_slice(part, tile, false, fill, report);
      rows = report.rows;
      if (status == Status::kTooLarge) {  // not one row: it is cut
        rows = planned.bh = 1;
        if (const Status cut = pack_rect(part, planned); cut != Status::kOk) return cut;
      } else if (status != Status::kOk) {
        return status;
      }
    }
    rest.by += rows;
    rest.bh -= rows;
  }
  return Status::kOk;
}

}  // namespace planecast
