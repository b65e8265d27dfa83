#include "core/wire/tile_unpack.hpp"

#include <algorithm>

namespace planecast {
namespace {

Status read_coefficient(RangeDecoder& coder, int shift, std::int32_t& value) noexcept {
  const auto length = static_cast<int>(coder.raw(5));
  value = 0;
  if (length == 0) return Status::kOk;
  if (length + shift > 30) return Status::kFieldRange;
  const bool negative = coder.raw(1) != 0;
  std::uint32_t magnitude = length > 16 ? coder.raw(length - 16) : 0;
  const int low = std::min(length, 16);
  magnitude = (magnitude << low) | coder.raw(low);
  value = static_cast<std::int32_t>(magnitude << shift);
  if (negative) value = -value;
  return Status::kOk;
}

std::uint32_t read_tree(RangeDecoder& coder, BitModel* models, int bits) noexcept {
  std::uint32_t node = 1;
  for (int i = 0; i < bits; ++i) node = node * 2 + (coder.bit(models[node]) ? 1 : 0);
  return node - (1U << bits);
}

}  // namespace

// One call of unpack(): the tile's place and what is derived from it.
struct TileUnpacker::Job {
  const CodingTables& tables;
  const TileTarget& target;
  TileContent& content;
  TileSpan span;
  bool surfaces_kind = false;
  Status status = Status::kOk;  ///< first impossible value met inside a row
  std::int32_t last_level = 1;
  std::int32_t fallback = 1;
  Surface surfaces[kMaxSurfaces + 1] = {};

  const TileRect& rect() const noexcept { return content.rect; }
  std::uint32_t width() const noexcept { return tables.config->camera.width; }
};

void TileUnpacker::layout(Arena& arena, std::uint32_t max_width) noexcept {
  const std::uint32_t blocks = std::min<std::uint32_t>((max_width + 7) / 8, kMaxTileBlocks);
  rows_ = arena.take<PixelState>(3 * row_states(blocks));
  blocks_ = arena.take<BlockState>(2 * std::size_t{blocks});
  surfaces_ = arena.take<BlockSurface>(blocks);
}

Status TileUnpacker::unpack(const CodingTables& tables, std::span<const std::uint8_t> in,
                            const TileTarget& target, TileContent& content) noexcept {
  content = {};
  Job job{.tables = tables, .target = target, .content = content, .span = {}};
  job.surfaces_kind = tables.config->tolerance == ToleranceKind::kSurfaces;
  job.last_level = static_cast<std::int32_t>(tables.levels->count()) - 1;
  RangeDecoder coder(in);
  models_ = trained_models(tables.bounds->lossless());
  Status status = read_head(job, coder);
  if (status != Status::kOk) return status;
  if (content.verbatim) {
    status = read_verbatim(job, coder);
  } else {
    std::fill_n(rows_.begin(), 3 * row_states(job.rect().bw), PixelState{});
    for (std::uint32_t row = 0; row < job.rect().bh && status == Status::kOk; ++row) {
      status = read_block_row(job, coder, row);
      const std::uint32_t end = std::min(row * 8 + 8, job.span.v1 - job.span.v0);
      for (std::uint32_t v = row * 8; v < end && status == Status::kOk; ++v)
        status = read_row(job, coder, v);
      if (coder.truncated()) status = Status::kTruncated;
    }
  }
  if (status == Status::kOk && coder.truncated()) status = Status::kTruncated;
  if (status == Status::kOk && coder.trailing()) status = Status::kTrailingBytes;
  if (status != Status::kOk) {
    for (std::uint32_t v = job.span.v0; v < job.span.v1; ++v) {
      const std::size_t begin = std::size_t{v} * job.width() + job.span.u0;
      const std::uint32_t wide = job.span.u1 - job.span.u0;
      std::fill_n(target.depth.data() + begin, wide, std::uint16_t{0});
      if (!target.labels.empty()) std::fill_n(target.labels.data() + begin, wide, std::uint8_t{0});
    }
  }
  return status;
}

Status TileUnpacker::read_head(Job& job, RangeDecoder& coder) noexcept {
  const CameraModel& camera = job.tables.config->camera;
  TileContent& content = job.content;
  content.verbatim = coder.raw(1) == kVerbatim;
  const int xb = position_bits(blocks_wide(camera));
  const int yb = position_bits(blocks_high(camera));
  TileRect rect;
  rect.bx = coder.raw(xb);
  rect.by = coder.raw(yb);
  rect.bw = coder.raw(std::min(xb, 8)) + 1;
  rect.bh = coder.raw(std::min(yb, 8)) + 1;
  if (rect.bx + rect.bw > blocks_wide(camera) || rect.by + rect.bh > blocks_high(camera)) {
    return Status::kFieldRange;
  }
  content.rect = rect;
  job.span = tile_span(camera, rect);
  if (content.verbatim) return Status::kOk;
  const auto first = static_cast<std::uint16_t>(coder.raw(16));
  job.fallback = std::max<std::int32_t>(1, job.tables.levels->nearest(first));
  content.surfaces = coder.raw(kLabelBits);
  if (content.surfaces == 0) return Status::kOk;
  const auto shift = static_cast<int>(coder.raw(5));
  for (std::uint32_t i = 1; i <= content.surfaces; ++i) {
    for (std::int32_t Surface::*coefficient : {&Surface::a, &Surface::b, &Surface::c}) {
      const Status status = read_coefficient(coder, shift, job.surfaces[i].*coefficient);
      if (status != Status::kOk) return status;
    }
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

Status TileUnpacker::read_block_row(Job& job, RangeDecoder& coder, std::uint32_t row) noexcept {
  BlockState* blocks = blocks_.data() + (row & 1U) * job.rect().bw;
  const BlockState* above = row > 0 ? blocks_.data() + ((row + 1) & 1U) * job.rect().bw : nullptr;
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
  if (block.uniform == 0 || !job.surfaces_kind || block.label.first == 0) {
    const int labelled = block.label.first != 0 ? 9 : 0;
    block.corrected = coder.bit(
        models_.block_corrected[labelled + pair_context(n.left, n.above, &BlockState::corrected)]);
  }
  return Status::kOk;
}

Status TileUnpacker::read_row(Job& job, RangeDecoder& coder, std::uint32_t tile_v) noexcept {
  RowCursor cursor(rows_.data(), job.rect().bw, tile_v);
  const std::size_t begin = std::size_t{job.span.v0 + tile_v} * job.width() + job.span.u0;
  std::uint16_t* depth = job.target.depth.data() + begin;
  std::uint8_t* labels = job.target.labels.empty() ? nullptr : job.target.labels.data() + begin;
  const BlockState* blocks = blocks_.data() + ((tile_v / 8) & 1U) * job.rect().bw;
  for (std::uint32_t x = 0; x < job.span.u1 - job.span.u0; ++x) {
    const Neighbourhood& around = cursor.look(x);
    const BlockState& block = blocks[x / 8];
    PixelState state;
    depth[x] = 0;
    const bool reading =
        block.any != 0 && (block.full != 0 || coder.bit(models_.mask[cursor.mask(x)]));
    if (reading) {
      state = read_reading(job, coder, around, x, tile_v, block, depth[x]);
      ++job.content.points;
      if (state.level == 0 || depth[x] == 0) return Status::kBadSymbol;
    }
    if (labels != nullptr) {
      const bool second = state.choice == 2;
      const bool off = job.surfaces_kind && state.choice == 0;
      labels[x] =
          !reading || off ? std::uint8_t{0} : (second ? block.label.second : block.label.first);
    }
    cursor.leave(x, state);
  }
  return job.status;
}

PixelState TileUnpacker::read_reading(Job& job, RangeDecoder& coder, const Neighbourhood& around,
                                      std::uint32_t x, std::uint32_t tile_v,
                                      const BlockState& block, std::uint16_t& depth) noexcept {
  const bool labelled = block.label.first != 0;
  PixelState state;
  if (job.surfaces_kind && labelled) {
    int choice = 1;
    if (block.uniform == 0) {
      const int context = choice_context(around);
      choice = coder.bit(models_.on_surface[0][context]) ? 1 : 0;
      if (choice == 0 && block.label.second != 0)
        choice = coder.bit(models_.on_surface[1][context]) ? 2 : 0;
    }
    if (choice != 0) {
      const std::uint8_t label = choice == 1 ? block.label.first : block.label.second;
      const std::uint32_t u = job.span.u0 + x, v = job.span.v0 + tile_v;
      depth =
          surface_depth(job.surfaces[label], job.tables.rays->x(u, v), job.tables.rays->y(u, v));
      state.level = job.tables.levels->nearest(depth);
      state.choice = static_cast<std::uint8_t>(choice);
      job.fallback = std::max<std::int32_t>(1, state.level);
      return state;
    }
  }
  const BoundTable& bounds = *job.tables.bounds;
  const std::uint8_t ray_class =
      bounds.ray_class(job.rect().bx + x / 8, job.rect().by + tile_v / 8);
  const BlockSurface& s = surfaces_[x / 8];
  const std::int32_t at = labelled ? s.at(x % 8, tile_v % 8) : 0;
  const PixelPrediction p =
      predict_pixel(around, labelled, at, s.dx, s.dy, bounds.half_widths(ray_class), job.last_level,
                    job.fallback);
  std::int32_t level = p.level;
  std::int32_t correction = 0;
  if (block.corrected != 0 && coder.bit(models_.correction[p.correction_context])) {
    level = read_correction(job, coder, p, correction, depth);
    ++job.content.corrections;
  }
  if (level < 1 || level > job.last_level) {
    job.status = Status::kBadSymbol;
    level = 1;
  }
  if (depth == 0) depth = job.tables.levels->depth(static_cast<std::uint32_t>(level));
  job.fallback = level;
  return pixel_state(p, level, correction);
}

std::int32_t TileUnpacker::read_correction(Job& job, RangeDecoder& coder, const PixelPrediction& p,
                                           std::int32_t& correction,
                                           std::uint16_t& depth) noexcept {
  const int sign = coder.bit(models_.sign[p.sign_context]) ? 1 : -1;
  BitModel* unary = models_.magnitude[p.magnitude_context];
  int more = 0;
  while (more < kMaxUnary && coder.bit(unary[more])) ++more;
  correction = sign * (more + 1);
  if (more < kMaxUnary) return p.level + correction * p.step();
  const auto length = static_cast<int>(read_tree(coder, models_.jump_length, kJumpBits));
  if (length == 0) {
    depth = static_cast<std::uint16_t>(coder.raw(16));
    if (depth == 0) job.status = Status::kBadSymbol;
    return std::max<std::int32_t>(1, job.tables.levels->nearest(depth));
  }
  if (length > 16) {
    job.status = Status::kBadSymbol;
    return p.level;
  }
  std::int32_t distance = 1;
  if (length > 1) {
    distance = 2 + (coder.bit(models_.jump_top[length]) ? 1 : 0);
    if (length > 2)
      distance = (distance << (length - 2)) + static_cast<std::int32_t>(coder.raw(length - 2));
  }
  return p.level + sign * distance;
}

}  // namespace planecast
