#include "core/wire/tile_pack.hpp"

#include <algorithm>
#include <cstdlib>

#include "core/wire/encode_io.hpp"
#include "core/wire/flat_fit.hpp"
#include "core/wire/run_tile.hpp"
#include "core/wire/tile_pack_job.hpp"
#include "core/wire/tile_write.hpp"

namespace planecast {
namespace {

std::uint16_t first_reading(const FrameModel& frame, const TileSpan& span,
                            std::uint32_t width) noexcept {
  for (std::uint32_t v = span.v0; v < span.v1; ++v) {
    for (std::uint32_t u = span.u0; u < span.u1; ++u) {
      if (frame.depth[std::size_t{v} * width + u] != 0)
        return frame.depth[std::size_t{v} * width + u];
    }
  }
  return 0;
}

std::size_t verbatim_bytes(const TileSpan& span) noexcept {
  return std::size_t{span.u1 - span.u0} * (span.v1 - span.v0) * 2 + 8;
}

// Of a block's pixels, `columns` x `rows`.
std::uint32_t count_readings(const std::uint16_t* depth, std::size_t width, std::uint32_t columns,
                             std::uint32_t rows) noexcept {
  std::uint32_t readings = 0;
  if (columns == 8) {
    Short8 holes = {};  // counted downwards
    for (std::uint32_t y = 0; y < rows; ++y)
      holes += reinterpret_cast<Short8>(load8(depth + y * width) == Count8{});
    return columns * rows - static_cast<std::uint32_t>(-sum8(holes));
  }
  for (std::uint32_t y = 0; y < rows; ++y) {
    for (std::uint32_t x = 0; x < columns; ++x) readings += depth[y * width + x] != 0;
  }
  return readings;
}

}  // namespace

void TilePacker::layout(Arena& arena, std::uint32_t max_width) noexcept {
  const std::uint32_t blocks = std::min<std::uint32_t>((max_width + 7) / 8, kMaxTileBlocks);
  rows_ = arena.take<PixelRow>(3);
  decisions_ = arena.take<PixelDecision>(std::size_t{blocks} * 64 * kMostDecisions);
  ends_ = arena.take<std::uint32_t>(std::size_t{blocks} * 8);
  found_ = arena.take<Residual>(std::size_t{blocks} * 64);
  jumps_ = arena.take<Jump>(std::size_t{blocks} * 64);
  blocks_ = arena.take<BlockState>(2 * std::size_t{blocks});
  planes_ = arena.take<BlockPlane>(2 * std::size_t{blocks});
  flats_ = arena.take<FlatChoice>(blocks);
  surfaces_ = arena.take<BlockSurface>(blocks);
  mix_.layout(arena, max_width);
}

Status TilePacker::pack(const CodingTables& tables, const FrameModel& frame, const TileRect& rect,
                        std::span<std::uint8_t> out, TileReport& report,
                        const TileFill& fill) noexcept {
  if (!tables.config->effort_best) return pack_plain(tables, frame, rect, out, report, fill);
  // Whichever is smaller: blending loses where readings lie on levels that nobody told of.
  TileReport plain;
  const Status status = pack_plain(tables, frame, rect, out, plain, fill);
  if (mix_.pack(tables, frame, rect, out, report, fill) == Status::kOk &&
      (status != Status::kOk || report.rows > plain.rows ||
       (report.rows == plain.rows && report.bytes <= plain.bytes))) {
    return Status::kOk;
  }
  return pack_plain(tables, frame, rect, out, report, fill);
}

Status TilePacker::pack_plain(const CodingTables& tables, const FrameModel& frame,
                              const TileRect& rect, std::span<std::uint8_t> out, TileReport& report,
                              const TileFill& fill) noexcept {
  const CameraModel& camera = tables.config->camera;
  Job job{.tables = tables, .frame = frame, .rect = rect, .span = tile_span(camera, rect)};
  job.surfaces_kind = tables.config->tolerance == ToleranceKind::kSurfaces;
  job.last_level = static_cast<std::int32_t>(tables.levels->count()) - 1;
  // Counts as they are set the upper limit of what a tile may cost.
  const std::size_t room = std::min(out.size(), verbatim_bytes(job.span));
  RangeEncoder coder(out.first(room));
  FillGate gate(fill, room);
  models_ = trained_models(tables.bounds->lossless());
  if (tables.bounds->lossless()) residuals_ = *tables.residuals;
  jumps_in_ = jumps_out_ = decided_ = 0;
  code_head(job, coder, fill.allowed() ? fill.planned : rect.bh);
  clear_rows(rows_, rect.bw);
  code_rows(job, coder, gate);
  std::size_t used = coder.finish();
  TileRect coded = rect;
  if (gate.allowed()) {
    coded.bh = gate.rows();
    if (coded.bh == 0) return Status::kTooLarge;
  }
  if (coder.overflow() || used > verbatim_bytes(tile_span(camera, coded)))
    return store(tables, frame, coded, out, report);
  if (coded.bh != rect.bh) used = recode_height(out, used, camera, rect.bh, coded.bh);
  report = {used, job.points, job.corrections, false, coded.bh};
  return Status::kOk;
}

void TilePacker::code_rows(Job& job, RangeEncoder& coder, FillGate& gate) noexcept {
  for (std::uint32_t row = 0; row < job.rect.bh && !coder.overflow(); ++row) {
    if (gate.allowed() && row > 0 &&
        (!gate.likely(coder, row) || !job.local.name_all(job.frame, job.tables, job.rect, row)))
      return;
    const std::uint32_t points = job.points, corrections = job.corrections;
    open_block_row(job, row);
    const std::uint32_t begin = job.span.v0 + row * 8;
    for (std::uint32_t v = begin; v < std::min(begin + 8, job.span.v1); ++v) {
      if (job.tables.bounds->lossless()) {
        quantise_lossless_row(job, v);
      } else {
        quantise_bounded_row(job, v);
      }
    }
    code_block_row(job, coder, row);
    if (gate.allowed() && !gate.keep(coder)) {
      job.points = points;
      job.corrections = corrections;
      return;
    }
  }
}

void TilePacker::code_head(Job& job, RangeEncoder& coder, std::uint32_t label_rows) noexcept {
  const CameraModel& camera = job.tables.config->camera;
  coder.raw(kModelled, 1);
  code_rect(coder, camera, job.rect);
  if (job.tables.config->effort_best) coder.raw(kPlainTile, 1);
  for (std::uint32_t row = 0; row < label_rows; ++row)
    job.local.use_row(job.frame, job.tables, job.rect, row);
  const std::uint16_t first = first_reading(job.frame, job.span, job.width());
  job.fallback = std::max<std::int32_t>(1, job.tables.levels->nearest(first));
  job.last_middle = job.fallback * 256;
  coder.raw(first, 16);
  coder.raw(static_cast<std::uint32_t>(job.local.count), kLabelBits);
  if (job.local.count == 0) return;
  coder.raw(job.frame.shift, 5);
  for (int i = 1; i <= job.local.count; ++i) {
    const Surface& surface = job.surface(static_cast<std::uint8_t>(i));
    code_surface(coder, surface, job.frame.shift);
  }
}

void TilePacker::open_block_row(Job& job, std::uint32_t row) noexcept {
  BlockState* blocks = blocks_.data() + (row & 1U) * job.rect.bw;
  const std::uint32_t by = job.rect.by + row;
  const BlockLabel* labels =
      &job.frame.blocks[std::size_t{by} * blocks_wide(job.tables.config->camera) + job.rect.bx];
  const std::uint32_t v_end = std::min(by * 8 + 8, job.span.v1);
  for (std::uint32_t i = 0; i < job.rect.bw; ++i) {
    const std::uint32_t bx = job.rect.bx + i;
    const std::uint32_t u_end = std::min(bx * 8 + 8, job.span.u1);
    const std::uint32_t readings =
        count_readings(&job.frame.depth[std::size_t{by} * 8 * job.width() + bx * 8], job.width(),
                       u_end - bx * 8, v_end - by * 8);
    BlockState& block = blocks[i];
    block = {};
    block.uniform = 1;
    if (readings == 0) {
      if (i > 0) block.label = blocks[i - 1].label;  // labels carry on over holes
      continue;
    }
    block.any = 1;
    block.full = readings == (u_end - bx * 8) * (v_end - by * 8);
    block.label.first = job.local.local_of[labels[i].first];
    if (job.surfaces_kind) block.label.second = job.local.local_of[labels[i].second];
    if (block.label.first != 0) {
      surfaces_[i] = block_surface(job.surface(block.label.first), *job.tables.rays,
                                   *job.tables.levels, bx, by);
    }
    job.points += readings;
    if (may_be_flat(job.tables, block)) try_flat(job, row, i);
  }
}

// Makes block i flat when one plane holds all its readings.
void TilePacker::try_flat(Job& job, std::uint32_t row, std::uint32_t i) noexcept {
  const std::uint32_t bw = job.rect.bw;
  BlockState* blocks = blocks_.data() + (row & 1U) * bw;
  const BlockState* above = row > 0 ? blocks_.data() + ((row + 1) & 1U) * bw : nullptr;
  BlockPlane* planes = planes_.data() + (row & 1U) * bw;
  const BlockPlane* planes_above = planes_.data() + ((row + 1) & 1U) * bw;
  const PlaneHints hints = plane_hints(blocks, above, planes, planes_above, i, bw, &surfaces_[i],
                                       TileRows(rows_, row * 8).above, job.last_middle);
  const BoundTable& bounds = *job.tables.bounds;
  const std::uint32_t bx = job.rect.bx + i, by = job.rect.by + row;
  const std::uint8_t ray_class = bounds.ray_class(bx, by);
  const std::uint8_t* half_widths = bounds.half_widths(ray_class);
  const BlockPlane foretold = foretell_plane(hints, half_widths, job.last_level);
  const PlaneSteps steps(half_widths[(foretold.middle + 128) >> 8]);
  FlatWindow window;
  load_window(bounds.windows(ray_class),
              &job.frame.depth[std::size_t{by} * 8 * job.width() + bx * 8], job.width(),
              std::min(8U, job.span.u1 - bx * 8), std::min(8U, job.span.v1 - by * 8), window);
  FlatChoice& flat = flats_[i];
  if (!fit_flat(window, foretold, steps, job.last_level, flat.code)) return;
  flat.contexts = PlaneContexts(hints);
  planes[i] = BlockPlane::clamped(foretold.middle + flat.code.offset * steps.offset,
                                  foretold.dx + flat.code.dx * steps.slope,
                                  foretold.dy + flat.code.dy * steps.slope, job.last_level);
  surfaces_[i] = planes[i].surface();
  job.last_middle = planes[i].middle;
  blocks[i].flat = 1;
}

Status TilePacker::pack_runs(const CodingTables& tables, const FrameModel& frame,
                             const TileRect& rect, std::span<std::uint8_t> out,
                             TileReport& report) noexcept {
  const TileSpan span = tile_span(tables.config->camera, rect);
  RangeEncoder coder(out.first(std::min(out.size(), verbatim_bytes(span))));
  coder.raw(kVerbatimTile, 1);
  code_rect(coder, tables.config->camera, rect);
  coder.raw(kRunTile, 1);
  EncodeIo io{coder};
  report = {};
  const Status status = RunTile<EncodeIo>(io, tables, rect, rows_).walk(frame.depth, report.points);
  report.bytes = coder.finish();
  report.rows = rect.bh;
  return coder.overflow() ? store(tables, frame, rect, out, report) : status;
}

// Counts as they are, 16 bits each.
Status TilePacker::store(const CodingTables& tables, const FrameModel& frame, const TileRect& rect,
                         std::span<std::uint8_t> out, TileReport& report) noexcept {
  const TileSpan span = tile_span(tables.config->camera, rect);
  RangeEncoder coder(out);
  coder.raw(kVerbatimTile, 1);
  code_rect(coder, tables.config->camera, rect);
  coder.raw(kCountsTile, 1);
  report = {};
  report.verbatim = true;
  report.rows = rect.bh;
  for (std::uint32_t v = span.v0; v < span.v1; ++v) {
    for (std::uint32_t u = span.u0; u < span.u1; ++u) {
      const std::uint16_t depth = frame.depth[std::size_t{v} * tables.config->camera.width + u];
      coder.raw(depth, 16);
      report.points += depth != 0;
    }
  }
  report.bytes = coder.finish();
  return coder.overflow() ? Status::kTooLarge : Status::kOk;
}

}  // namespace planecast
