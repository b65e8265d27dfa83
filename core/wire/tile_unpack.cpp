#include "core/wire/tile_unpack.hpp"

#include <algorithm>

#include "core/wire/decode_io.hpp"
#include "core/wire/run_tile.hpp"
#include "core/wire/tile_read.hpp"
#include "core/wire/tile_unpack_job.hpp"

namespace planecast {
void TileUnpacker::layout(Arena& arena, std::uint32_t max_width) noexcept {
  const std::uint32_t blocks = std::min<std::uint32_t>((max_width + 7) / 8, kMaxTileBlocks);
  rows_ = arena.take<PixelRow>(3);
  blocks_ = arena.take<BlockState>(2 * std::size_t{blocks});
  planes_ = arena.take<BlockPlane>(2 * std::size_t{blocks});
  surfaces_ = arena.take<BlockSurface>(blocks);
  mix_.layout(arena, max_width);
}

Status TileUnpacker::unpack(const CodingTables& tables, std::span<const std::uint8_t> in,
                            const TileTarget& target, TileContent& content) noexcept {
  content = {};
  Job job{.tables = tables, .target = target, .content = content, .span = {}};
  job.surfaces_kind = tables.config->tolerance == ToleranceKind::kSurfaces;
  job.lossless = tables.bounds->lossless();
  job.every_count = tables.levels->every_count();
  job.last_level = static_cast<std::int32_t>(tables.levels->count()) - 1;
  RangeDecoder coder(in);
  models_ = trained_models(tables.bounds->lossless());
  if (tables.bounds->lossless()) residuals_ = *tables.residuals;
  Status status = read_head(job, coder);
  if (status != Status::kOk) return status;
  if (content.runs) {
    status = read_runs(job, coder);
  } else if (content.verbatim) {
    status = read_verbatim(job, coder);
  } else if (content.mixed) {
    status = mix_.unpack(tables, coder, job.fallback, target, content);
  } else {
    clear_rows(rows_, job.rect().bw);
    for (std::uint32_t row = 0; row < job.rect().bh && status == Status::kOk; ++row) {
      status = read_block_row(job, coder, row);
      const std::uint32_t end = std::min(row * 8 + 8, job.span.v1 - job.span.v0);
      for (std::uint32_t v = row * 8; v < end && status == Status::kOk; ++v)
        status = !job.lossless     ? read_row(job, coder, v)
                 : job.every_count ? read_lossless_row<true>(job, coder, v)
                                   : read_lossless_row<false>(job, coder, v);
      if (coder.truncated()) status = Status::kTruncated;
    }
  }
  if (status == Status::kOk && coder.truncated()) status = Status::kTruncated;
  if (status == Status::kOk && coder.trailing()) status = Status::kTrailingBytes;
  if (status != Status::kOk) {
    for (std::uint32_t v = job.span.v0; v < job.span.v1; ++v)
      std::fill_n(target.depth.data() + std::size_t{v} * job.width() + job.span.u0,
                  job.span.u1 - job.span.u0, std::uint16_t{0});
    clear_labels(job);
  }
  return status;
}

void TileUnpacker::clear_labels(const Job& job) noexcept {
  if (job.target.labels.empty()) return;
  for (std::uint32_t v = job.span.v0; v < job.span.v1; ++v)
    std::fill_n(job.target.labels.data() + std::size_t{v} * job.width() + job.span.u0,
                job.span.u1 - job.span.u0, std::uint8_t{0});
}

Status TileUnpacker::peek(const CameraModel& camera, std::span<const std::uint8_t> in,
                          TileRect& rect) noexcept {
  RangeDecoder coder(in);
  bool modelled = false;
  const Status status = read_place(camera, coder, modelled, rect);
  return status == Status::kOk && coder.truncated() ? Status::kTruncated : status;
}

Status TileUnpacker::read_place(const CameraModel& camera, RangeDecoder& coder, bool& modelled,
                                TileRect& rect) noexcept {
  modelled = coder.raw(1) == kModelled;
  const int xb = position_bits(blocks_wide(camera));
  const int yb = position_bits(blocks_high(camera));
  rect.bx = coder.raw(xb);
  rect.by = coder.raw(yb);
  rect.bw = coder.raw(std::min(xb, 8)) + 1;
  rect.bh = coder.raw(std::min(yb, 8)) + 1;
  if (rect.bx + rect.bw > blocks_wide(camera) || rect.by + rect.bh > blocks_high(camera)) {
    return Status::kFieldRange;
  }
  return Status::kOk;
}

Status TileUnpacker::read_head(Job& job, RangeDecoder& coder) noexcept {
  const CameraModel& camera = job.tables.config->camera;
  TileContent& content = job.content;
  TileRect rect;
  bool modelled = false;
  if (const Status status = read_place(camera, coder, modelled, rect); status != Status::kOk)
    return status;
  content.rect = rect;
  job.span = tile_span(camera, rect);
  if (!modelled) {
    content.runs = coder.raw(1) == kRunTile;
    content.verbatim = !content.runs;
    clear_labels(job);
    return Status::kOk;
  }
  if (job.tables.config->effort_best) content.mixed = coder.raw(1) == kMixedTile;
  const auto first = static_cast<std::uint16_t>(coder.raw(16));
  job.fallback = std::max<std::int32_t>(1, job.tables.levels->nearest(first));
  job.last_middle = job.fallback * 256;
  content.surfaces = coder.raw(kLabelBits);
  if (content.surfaces == 0) return Status::kOk;
  const auto shift = static_cast<int>(coder.raw(5));
  for (std::uint32_t i = 1; i <= content.surfaces; ++i) {
    const Status status = read_surface(coder, shift, job.surfaces[i]);
    if (status != Status::kOk) return status;
    content.surface[i - 1] = job.surfaces[i];
  }
  return Status::kOk;
}

Status TileUnpacker::read_verbatim(Job& job, RangeDecoder& coder) noexcept {
  for (std::uint32_t v = job.span.v0; v < job.span.v1; ++v) {
    std::uint16_t* depth = &job.target.depth[std::size_t{v} * job.width()];
    for (std::uint32_t u = job.span.u0; u < job.span.u1; ++u) {
      depth[u] = static_cast<std::uint16_t>(coder.raw(16));
      job.content.points += depth[u] != 0;
    }
    if (coder.truncated()) return Status::kTruncated;
  }
  return Status::kOk;
}

Status TileUnpacker::read_runs(Job& job, RangeDecoder& coder) noexcept {
  DecodeIo io{coder};
  RunTile<DecodeIo> tile(io, job.tables, job.rect(), rows_);
  return tile.walk(job.target.depth, job.content.points);
}

Status TileUnpacker::read_block_row(Job& job, RangeDecoder& coder, std::uint32_t row) noexcept {
  BlockState* blocks = blocks_.data() + (row & 1U) * job.rect().bw;
  const BlockState* above = row > 0 ? blocks_.data() + ((row + 1) & 1U) * job.rect().bw : nullptr;
  BlockPlane* planes = planes_.data() + (row & 1U) * job.rect().bw;
  const BlockPlane* planes_above = planes_.data() + ((row + 1) & 1U) * job.rect().bw;
  const PixelRow& row_above = TileRows(rows_, row * 8).above;
  for (std::uint32_t i = 0; i < job.rect().bw; ++i) {
    const Status status =
        read_block(job, coder, blocks[i],
                   {i > 0 ? &blocks[i - 1] : nullptr, above != nullptr ? &above[i] : nullptr,
                    i > 0 && above != nullptr ? &above[i - 1] : nullptr});
    if (status != Status::kOk) return status;
    if (blocks[i].label.first != 0 && blocks[i].any != 0) {
      surfaces_[i] = block_surface(job.surfaces[blocks[i].label.first], *job.tables.rays,
                                   *job.tables.levels, job.rect().bx + i, job.rect().by + row);
    }
    if (blocks[i].flat == 0) continue;
    const BoundTable& bounds = *job.tables.bounds;
    const PlaneHints hints = plane_hints(blocks, above, planes, planes_above, i, job.rect().bw,
                                         &surfaces_[i], row_above, job.last_middle);
    planes[i] =
        read_plane(coder, models_, hints,
                   bounds.half_widths(bounds.ray_class(job.rect().bx + i, job.rect().by + row)),
                   job.last_level);
    job.last_middle = planes[i].middle;
    surfaces_[i] = planes[i].surface();
  }
  return Status::kOk;
}

Status TileUnpacker::read_block(Job& job, RangeDecoder& coder, BlockState& block,
                                const BlockNeighbours& n) noexcept {
  block = {};
  block.uniform = 1;
  const std::uint8_t left = n.left != nullptr ? n.left->label.first : std::uint8_t{0};
  block.any = coder.bit(models_.block_any[pair_context(n.left, n.above, &BlockState::any)]);
  if (block.any == 0) {
    if (n.left != nullptr) block.label = n.left->label;
    return Status::kOk;
  }
  block.full = coder.bit(models_.block_full[pair_context(n.left, n.above, &BlockState::full)]);
  if (job.content.surfaces > 0) {
    const int context = label_context(n);
    const std::uint8_t above = n.above != nullptr ? n.above->label.first : std::uint8_t{0};
    block.label.first = left;
    if (!coder.bit(models_.label_as_left[context])) {
      block.label.first = above;
      if (above == left || !coder.bit(models_.label_as_above[context])) {
        block.label.first =
            static_cast<std::uint8_t>(read_tree(coder, models_.label_index, kLabelBits));
      }
    }
    if (job.surfaces_kind && block.label.first != 0) {
      if (coder.bit(models_.block_second[0])) {
        block.label.second =
            static_cast<std::uint8_t>(read_tree(coder, models_.label_index, kLabelBits));
      }
      block.uniform = coder.bit(models_.block_uniform[block.label.second != 0 ? 1 : 0]);
    }
    if (block.label.first > job.content.surfaces || block.label.second > job.content.surfaces) {
      return Status::kBadSymbol;
    }
  }
  if (may_be_flat(job.tables, block)) {
    block.flat = coder.bit(models_.block_flat[flat_context(n, block)]);
    if (block.flat != 0) return Status::kOk;
  }
  if (block.uniform == 0 || !job.surfaces_kind || block.label.first == 0) {
    const int labelled = block.label.first != 0 ? 9 : 0;
    block.corrected = coder.bit(
        models_.block_corrected[labelled + pair_context(n.left, n.above, &BlockState::corrected)]);
  }
  return Status::kOk;
}

// A level far from `from`, 0 for one that cannot be; `depth` becomes the count when that is off the
// levels.
std::int32_t TileUnpacker::read_jump(const LevelTable& levels, RangeDecoder& coder,
                                     std::int32_t from, std::int32_t sign,
                                     std::uint16_t& depth) noexcept {
  const auto length = static_cast<int>(read_tree(coder, models_.jump_length, kJumpBits));
  if (length == 0) {
    depth = static_cast<std::uint16_t>(coder.raw(16));
    return levels.nearest(depth);
  }
  if (length > 16) return 0;
  std::int32_t distance = 1;
  if (length > 1) {
    distance = 2 + (coder.bit(models_.jump_top[length]) ? 1 : 0);
    if (length > 2)
      distance = (distance << (length - 2)) + static_cast<std::int32_t>(coder.raw(length - 2));
  }
  return from + sign * distance;
}

}  // namespace planecast
