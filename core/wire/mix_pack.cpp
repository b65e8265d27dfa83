#include "core/wire/mix_pack.hpp"

#include <algorithm>
#include <cstdlib>

#include "core/wire/correction_search.hpp"
#include "core/wire/flat_fit.hpp"
#include "core/wire/tile_pack_job.hpp"
#include "core/wire/tile_write.hpp"

namespace planecast {
namespace {

// What the encoder says of a tile, in the order in which MixTile asks.
struct MixWriter {
  static constexpr bool kEncodes = true;
  RangeEncoder coder;
  const FrameModel& frame;
  FillGate gate;
  LocalSurfaces local = {};
  std::uint32_t points = 0, corrections = 0;  ///< of the rows of blocks kept

  bool bit(BitModel& model, bool want) noexcept {
    coder.bit(model, want);
    return want;
  }
  bool bit_at(std::uint32_t probability, bool want) noexcept {
    coder.bit_at(probability, want);
    return want;
  }
  std::uint32_t raw(std::uint32_t want, int bits) noexcept {
    coder.raw(want, bits);
    return want;
  }
  bool stopped() const noexcept { return coder.overflow(); }
  bool begins_row(const MixJob& job, std::uint32_t row) noexcept {
    return !gate.allowed() || row == 0 ||
           (gate.likely(coder, row) && local.name_all(frame, job.tables, job.rect, row));
  }
  bool keeps_row(const MixJob& job) noexcept {
    if (gate.allowed() && !gate.keep(coder)) return false;
    points = job.points;
    corrections = job.corrections;
    return true;
  }

  const std::uint16_t* depths(const MixJob& job, std::uint32_t v) const noexcept {
    return &frame.depth[std::size_t{job.span.v0 + v} * job.tables.config->camera.width +
                        job.span.u0];
  }
  std::uint16_t want_depth(const MixJob& job, std::uint32_t x, std::uint32_t v) const noexcept {
    return depths(job, v)[x];
  }

  BlockState want_block(const MixJob& job, std::uint32_t row, std::uint32_t i) const noexcept {
    const std::uint32_t x1 = std::min(i * 8 + 8, job.columns());
    const std::uint32_t v1 = std::min(row * 8 + 8, job.span.v1 - job.span.v0);
    std::uint32_t readings = 0;
    for (std::uint32_t v = row * 8; v < v1; ++v) {
      for (std::uint32_t x = i * 8; x < x1; ++x) readings += depths(job, v)[x] != 0;
    }
    BlockState want;
    if (readings == 0) return want;
    want.any = 1;
    want.full = readings == (x1 - i * 8) * (v1 - row * 8);
    const BlockLabel& label =
        frame.blocks[std::size_t{job.rect.by + row} * blocks_wide(job.tables.config->camera) +
                     job.rect.bx + i];
    want.label.first = local.local_of[label.first];
    if (!job.surfaces_kind || want.label.first == 0) return want;
    want.label.second = local.local_of[label.second];
    const std::uint8_t ray_class = job.tables.bounds->ray_class(job.rect.bx + i, job.rect.by + row);
    want.uniform = 1;
    for (std::uint32_t v = row * 8; v < v1; ++v) {
      for (std::uint32_t x = i * 8; x < x1; ++x) {
        const std::uint16_t depth = depths(job, v)[x];
        if (depth != 0 && want_choice(job, want, ray_class, x, v, depth) != 1) want.uniform = 0;
      }
    }
    return want;
  }

  // The first of a block's surfaces that holds a reading; 0 none.
  std::uint8_t want_choice(const MixJob& job, const BlockState& block, std::uint32_t ray_class,
                           std::uint32_t x, std::uint32_t v, std::uint16_t depth) const noexcept {
    const std::uint32_t limit =
        job.tables.bounds->max_error(depth, static_cast<std::uint8_t>(ray_class));
    const std::int32_t rx = job.tables.rays->x(job.span.u0 + x, job.span.v0 + v);
    const std::int32_t ry = job.tables.rays->y(job.span.u0 + x, job.span.v0 + v);
    for (std::uint8_t choice = 1; choice <= 2; ++choice) {
      const std::uint8_t label = choice == 1 ? block.label.first : block.label.second;
      if (label == 0) break;
      const std::uint16_t on = surface_depth(job.surfaces[label], rx, ry);
      if (on != 0 && static_cast<std::uint32_t>(std::abs(int{on} - int{depth})) <= limit)
        return choice;
    }
    return 0;
  }

  bool want_plane(const MixJob& job, std::uint32_t row, std::uint32_t i, std::uint8_t ray_class,
                  const BlockPlane& foretold, const PlaneSteps& steps,
                  PlaneCode& want) const noexcept {
    FlatWindow window;
    load_window(job.tables.bounds->windows(ray_class), depths(job, row * 8) + i * 8,
                job.tables.config->camera.width, std::min(8U, job.columns() - i * 8),
                std::min(8U, job.span.v1 - job.span.v0 - row * 8), window);
    FlatCode code;
    if (!fit_flat(window, foretold, steps, job.last_level, code)) return false;
    want = {code.offset, code.dx, code.dy};
    return true;
  }

  // The correction of a reading, in steps; kMaxUnary + 1 announces `jump`.
  std::int32_t want_correction(const MixJob& job, const BlendedPixel& p, std::uint32_t ray_class,
                               std::uint16_t depth, MixJump& jump) const noexcept {
    const LevelWindow window =
        job.tables.bounds->windows(static_cast<std::uint8_t>(ray_class))[depth];
    if (p.level >= window.low && p.level <= window.high) return 0;
    const Correction found = find_correction(*job.tables.levels, p, depth, window, job.last_level);
    if (std::abs(found.steps) > kMaxUnary) jump = {found.jump, depth};
    return found.steps;
  }
};

std::uint16_t first_reading(const MixWriter& writer, const MixJob& job) noexcept {
  for (std::uint32_t v = 0; v < job.span.v1 - job.span.v0; ++v) {
    for (std::uint32_t x = 0; x < job.columns(); ++x) {
      if (const std::uint16_t depth = writer.want_depth(job, x, v); depth != 0) return depth;
    }
  }
  return 0;
}

void code_head(MixWriter& writer, MixJob& job, std::uint32_t label_rows) noexcept {
  const CameraModel& camera = job.tables.config->camera;
  RangeEncoder& coder = writer.coder;
  coder.raw(kModelled, 1);
  code_rect(coder, camera, job.rect);
  coder.raw(kMixedTile, 1);
  for (std::uint32_t row = 0; row < label_rows; ++row)
    writer.local.use_row(writer.frame, job.tables, job.rect, row);
  const std::uint16_t first = first_reading(writer, job);
  job.begin_at(first);
  coder.raw(first, 16);
  job.surface_count = writer.local.count;
  coder.raw(static_cast<std::uint32_t>(job.surface_count), kLabelBits);
  if (job.surface_count == 0) return;
  coder.raw(writer.frame.shift, 5);
  for (int i = 1; i <= job.surface_count; ++i) {
    job.surfaces[i] = writer.frame.surfaces[writer.local.frame_of[i] - 1U];
    code_surface(coder, job.surfaces[i], writer.frame.shift);
  }
}

}  // namespace

Status MixPacker::pack(const CodingTables& tables, const FrameModel& frame, const TileRect& rect,
                       std::span<std::uint8_t> out, TileReport& report,
                       const TileFill& fill) noexcept {
  MixJob job(tables, rect);
  // Counts as they are set the upper limit of what a tile may cost.
  const std::size_t verbatim_bytes =
      std::size_t{job.columns()} * (job.span.v1 - job.span.v0) * 2 + 8;
  const std::size_t room = std::min(out.size(), verbatim_bytes);
  MixWriter writer{RangeEncoder(out.first(room)), frame, FillGate(fill, room)};
  code_head(writer, job, fill.allowed() ? fill.planned : rect.bh);
  const Status status = MixTile<MixWriter>(job, scratch_, writer).code();
  if (status != Status::kOk) return status;
  std::size_t used = writer.coder.finish();
  std::uint32_t rows = rect.bh;
  if (fill.allowed()) rows = writer.gate.rows();
  if (writer.coder.overflow() || rows == 0) return Status::kTooLarge;
  if (rows != rect.bh) used = recode_height(out, used, tables.config->camera, rect.bh, rows);
  report = {used, writer.points, writer.corrections, false, rows};
  return Status::kOk;
}

}  // namespace planecast
