#include "core/wire/tile_pack.hpp"

#include <algorithm>
#include <cstdlib>

namespace planecast {
namespace {

// Tile-local numbers of the frame's surfaces that the tile uses, in order of first use.
struct LocalSurfaces {
  std::uint8_t local_of[kMaxSurfaces + 1] = {};
  std::uint8_t frame_of[kMaxSurfaces + 1] = {};
  int count = 0;

  void use(std::uint8_t label) noexcept {
    if (label == 0 || local_of[label] != 0) return;
    local_of[label] = static_cast<std::uint8_t>(++count);
    frame_of[count] = label;
  }
};

void code_coefficient(RangeEncoder& coder, std::int32_t value, int shift) noexcept {
  const std::int32_t scaled = value >> shift;
  const auto magnitude = static_cast<std::uint32_t>(std::abs(scaled));
  const int length = static_cast<int>(std::bit_width(magnitude));
  coder.raw(static_cast<std::uint32_t>(length), 5);
  if (length == 0) return;
  coder.raw(scaled < 0 ? 1 : 0, 1);
  if (length > 16) coder.raw(magnitude >> 16U, length - 16);
  const int low = std::min(length, 16);
  coder.raw(magnitude & ((1U << low) - 1U), low);
}

void code_tree(RangeEncoder& coder, BitModel* models, int bits, std::uint32_t value) noexcept {
  std::uint32_t node = 1;
  for (int i = bits - 1; i >= 0; --i) {
    const bool bit = ((value >> i) & 1U) != 0;
    coder.bit(models[node], bit);
    node = node * 2 + (bit ? 1 : 0);
  }
}

void code_rect(RangeEncoder& coder, const CameraModel& camera, const TileRect& rect) noexcept {
  const int xb = position_bits(blocks_wide(camera));
  const int yb = position_bits(blocks_high(camera));
  coder.raw(rect.bx, xb);
  coder.raw(rect.by, yb);
  coder.raw(rect.bw - 1, std::min(xb, 8));
  coder.raw(rect.bh - 1, std::min(yb, 8));
}

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

}  // namespace

// One call of pack(): the tile's place and what is derived from it.
struct TilePacker::Job {
  const CodingTables& tables;
  const FrameModel& frame;
  TileRect rect;
  TileSpan span;
  bool surfaces_kind = false;
  std::int32_t last_level = 1;
  std::int32_t fallback = 1;  ///< level of the pixel coded last
  LocalSurfaces local = {};
  std::uint32_t points = 0, corrections = 0;

  std::uint32_t width() const noexcept { return tables.config->camera.width; }
  const Surface& surface(std::uint8_t local_label) const noexcept {
    return frame.surfaces[local.frame_of[local_label] - 1U];
  }
};

void TilePacker::layout(Arena& arena, std::uint32_t max_width) noexcept {
  const std::uint32_t blocks = std::min<std::uint32_t>((max_width + 7) / 8, kMaxTileBlocks);
  rows_ = arena.take<PixelState>(3 * row_states(blocks));
  tokens_ = arena.take<Token>(std::size_t{blocks} * 64);
  blocks_ = arena.take<BlockState>(2 * std::size_t{blocks});
  surfaces_ = arena.take<BlockSurface>(blocks);
}

Status TilePacker::pack(const CodingTables& tables, const FrameModel& frame, const TileRect& rect,
                        std::span<std::uint8_t> out, TileReport& report) noexcept {
  const CameraModel& camera = tables.config->camera;
  Job job{.tables = tables, .frame = frame, .rect = rect, .span = tile_span(camera, rect)};
  job.surfaces_kind = tables.config->tolerance == ToleranceKind::kSurfaces;
  job.last_level = static_cast<std::int32_t>(tables.levels->count()) - 1;
  // Counts as they are set the upper limit of what a tile may cost.
  const std::size_t verbatim_bytes =
      std::size_t{job.span.u1 - job.span.u0} * (job.span.v1 - job.span.v0) * 2 + 8;
  RangeEncoder coder(out.first(std::min(out.size(), verbatim_bytes)));
  models_ = trained_models(tables.bounds->lossless());
  code_head(job, coder);
  std::fill_n(rows_.begin(), 3 * row_states(rect.bw), PixelState{});
  for (std::uint32_t row = 0; row < rect.bh && !coder.overflow(); ++row) {
    open_block_row(job, row);
    const std::uint32_t begin = job.span.v0 + row * 8;
    for (std::uint32_t v = begin; v < std::min(begin + 8, job.span.v1); ++v) quantise_row(job, v);
    code_block_row(job, coder, row);
  }
  const std::size_t used = coder.finish();
  if (coder.overflow()) return pack_verbatim(tables, frame, rect, out, report);
  report = {used, job.points, job.corrections, false};
  return Status::kOk;
}

void TilePacker::code_head(Job& job, RangeEncoder& coder) noexcept {
  const CameraModel& camera = job.tables.config->camera;
  coder.raw(kModelled, 1);
  code_rect(coder, camera, job.rect);
  for (std::uint32_t by = 0; by < job.rect.bh; ++by) {
    const BlockLabel* labels =
        &job.frame.blocks[std::size_t{job.rect.by + by} * blocks_wide(camera) + job.rect.bx];
    for (std::uint32_t bx = 0; bx < job.rect.bw; ++bx) {
      job.local.use(labels[bx].first);
      if (job.surfaces_kind) job.local.use(labels[bx].second);
    }
  }
  const std::uint16_t first = first_reading(job.frame, job.span, job.width());
  job.fallback = std::max<std::int32_t>(1, job.tables.levels->nearest(first));
  coder.raw(first, 16);
  coder.raw(static_cast<std::uint32_t>(job.local.count), kLabelBits);
  if (job.local.count == 0) return;
  coder.raw(job.frame.shift, 5);
  for (int i = 1; i <= job.local.count; ++i) {
    const Surface& surface = job.surface(static_cast<std::uint8_t>(i));
    code_coefficient(coder, surface.a, job.frame.shift);
    code_coefficient(coder, surface.b, job.frame.shift);
    code_coefficient(coder, surface.c, job.frame.shift);
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
    std::uint32_t readings = 0;
    for (std::uint32_t v = by * 8; v < v_end; ++v) {
      const std::uint16_t* depth = &job.frame.depth[std::size_t{v} * job.width()];
      for (std::uint32_t u = bx * 8; u < u_end; ++u) readings += depth[u] != 0;
    }
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
  }
}

void TilePacker::quantise_row(Job& job, std::uint32_t v) noexcept {
  const std::uint32_t tile_v = v - job.span.v0;
  RowCursor cursor(rows_.data(), job.rect.bw, tile_v);
  Token* tokens = tokens_.data() + std::size_t{tile_v % 8} * job.rect.bw * 8;
  const std::uint16_t* depth = &job.frame.depth[std::size_t{v} * job.width() + job.span.u0];
  BlockState* blocks = blocks_.data() + ((tile_v / 8) & 1U) * job.rect.bw;
  for (std::uint32_t x = 0; x < job.span.u1 - job.span.u0; ++x) {
    const Neighbourhood& around = cursor.look(x);
    Token& token = tokens[x];
    BlockState& block = blocks[x / 8];
    token.reading = depth[x] != 0;
    if (block.full == 0) token.mask_context = static_cast<std::uint8_t>(cursor.mask(x));
    PixelState state;
    if (token.reading) state = quantise_reading(job, around, x, tile_v, depth[x], block, token);
    cursor.leave(x, state);
  }
}

PixelState TilePacker::quantise_reading(Job& job, const Neighbourhood& around, std::uint32_t x,
                                        std::uint32_t tile_v, std::uint16_t depth,
                                        BlockState& block, Token& token) noexcept {
  const BoundTable& bounds = *job.tables.bounds;
  const std::uint8_t ray_class = bounds.ray_class(job.rect.bx + x / 8, job.rect.by + tile_v / 8);
  const std::uint32_t limit = bounds.max_error(depth, ray_class);
  PixelState state;
  token.choice = 0;
  if (job.surfaces_kind && block.label.first != 0) {
    token.choice_context = static_cast<std::uint8_t>(choice_context(around));
    state = choose_surface(job, x, tile_v, depth, limit, block, token);
    if (token.choice != 1) block.uniform = 0;
  }
  if (token.choice == 0) {
    const bool labelled = block.label.first != 0;
    const BlockSurface& s = surfaces_[x / 8];
    const std::int32_t at = labelled ? s.at(x % 8, tile_v % 8) : 0;
    const PixelPrediction p =
        predict_pixel(around, labelled, at, s.dx, s.dy, bounds.half_widths(ray_class),
                      job.last_level, job.fallback);
    token.correction_context = p.correction_context;
    token.sign_context = p.sign_context;
    token.magnitude_context = p.magnitude_context;
    const std::int32_t level = correct(job, p, depth, limit, token);
    if (token.correction != 0) {
      block.corrected = 1;
      ++job.corrections;
    }
    state = pixel_state(p, level, token.correction);
  }
  job.fallback = state.level;
  return state;
}

PixelState TilePacker::choose_surface(const Job& job, std::uint32_t x, std::uint32_t tile_v,
                                      std::uint16_t depth, std::uint32_t limit,
                                      const BlockState& block, Token& token) const noexcept {
  PixelState state;
  const std::uint32_t u = job.span.u0 + x, v = job.span.v0 + tile_v;
  const std::int32_t rx = job.tables.rays->x(u, v), ry = job.tables.rays->y(u, v);
  for (int side = 1; side <= 2; ++side) {
    const std::uint8_t label = side == 1 ? block.label.first : block.label.second;
    if (label == 0) break;
    const std::uint16_t on = surface_depth(job.surface(label), rx, ry);
    if (on == 0 || static_cast<std::uint32_t>(std::abs(int{on} - int{depth})) > limit) continue;
    token.choice = static_cast<std::uint8_t>(side);
    token.correction = 0;
    state.level = job.tables.levels->nearest(on);
    state.choice = token.choice;
    return state;
  }
  return state;
}

std::int32_t TilePacker::correct(const Job& job, const PixelPrediction& p, std::uint16_t depth,
                                 std::uint32_t limit, Token& token) noexcept {
  const LevelTable& levels = *job.tables.levels;
  const auto within = [&](std::int32_t level) {
    return static_cast<std::uint32_t>(std::abs(
               int{levels.depth(static_cast<std::uint32_t>(level))} - int{depth})) <= limit;
  };
  token.correction = 0;
  if (within(p.level)) return p.level;
  const std::int32_t own = levels.nearest(depth);
  const int sign =
      own > p.level || (own == p.level && depth > levels.depth(static_cast<std::uint32_t>(own)))
          ? 1
          : -1;
  const std::int32_t step = p.step();
  // The first step whose window may hold the reading, and the two after it.
  const std::int32_t first = std::max(1, (std::abs(own - p.level) - 2 * p.half_width) / step);
  for (std::int32_t n = first; n <= first + 3 && n <= kMaxUnary; ++n) {
    const std::int32_t level = p.level + sign * n * step;
    if (level < 1 || level > job.last_level) break;
    if (!within(level)) continue;
    token.correction = static_cast<std::int16_t>(sign * n);
    return level;
  }
  token.correction = static_cast<std::int16_t>(sign * (kMaxUnary + 1));
  token.jump = within(own) ? std::abs(own - p.level) : 0;
  token.raw_depth = token.jump == 0 ? depth : std::uint16_t{0};
  return own;
}

void TilePacker::code_block_row(Job& job, RangeEncoder& coder, std::uint32_t row) noexcept {
  const BlockState* blocks = blocks_.data() + (row & 1U) * job.rect.bw;
  const BlockState* above = row > 0 ? blocks_.data() + ((row + 1) & 1U) * job.rect.bw : nullptr;
  for (std::uint32_t i = 0; i < job.rect.bw; ++i) {
    code_block(job, coder, blocks[i],
               {i > 0 ? &blocks[i - 1] : nullptr, above != nullptr ? &above[i] : nullptr,
                i > 0 && above != nullptr ? &above[i - 1] : nullptr});
  }
  const std::uint32_t begin = job.span.v0 + row * 8;
  const std::uint32_t rows = std::min(begin + 8, job.span.v1) - begin;
  const std::uint32_t columns = job.span.u1 - job.span.u0;
  for (std::uint32_t y = 0; y < rows; ++y) {
    const Token* tokens = tokens_.data() + std::size_t{y} * job.rect.bw * 8;
    for (std::uint32_t x = 0; x < columns; ++x) {
      const BlockState& block = blocks[x / 8];
      // Nothing to say of most pixels.
      if (block.any == 0) continue;
      if (block.full != 0 && block.corrected == 0 && block.uniform != 0) continue;
      code_pixel(job, coder, block, tokens[x]);
    }
  }
}

void TilePacker::code_block(const Job& job, RangeEncoder& coder, const BlockState& block,
                            const BlockNeighbours& n) noexcept {
  coder.bit(models_.block_any[pair_context(n.left, n.above, &BlockState::any)], block.any != 0);
  if (block.any == 0) return;
  coder.bit(models_.block_full[pair_context(n.left, n.above, &BlockState::full)], block.full != 0);
  if (job.local.count > 0) {
    const int context = label_context(n);
    const std::uint8_t left = n.left != nullptr ? n.left->label.first : std::uint8_t{0};
    const std::uint8_t above = n.above != nullptr ? n.above->label.first : std::uint8_t{0};
    coder.bit(models_.label_as_left[context], block.label.first == left);
    if (block.label.first != left) {
      if (above != left) coder.bit(models_.label_as_above[context], block.label.first == above);
      if (above == left || block.label.first != above) {
        code_tree(coder, models_.label_index, kLabelBits, block.label.first);
      }
    }
    if (job.surfaces_kind && block.label.first != 0) {
      coder.bit(models_.block_second[0], block.label.second != 0);
      if (block.label.second != 0)
        code_tree(coder, models_.label_index, kLabelBits, block.label.second);
      coder.bit(models_.block_uniform[block.label.second != 0 ? 1 : 0], block.uniform != 0);
    }
  }
  if (block.uniform == 0 || !job.surfaces_kind || block.label.first == 0) {
    const int labelled = block.label.first != 0 ? 9 : 0;
    coder.bit(
        models_.block_corrected[labelled + pair_context(n.left, n.above, &BlockState::corrected)],
        block.corrected != 0);
  }
}

void TilePacker::code_pixel(const Job& job, RangeEncoder& coder, const BlockState& block,
                            const Token& token) noexcept {
  if (block.full == 0) coder.bit(models_.mask[token.mask_context], token.reading);
  if (!token.reading) return;
  if (job.surfaces_kind && block.label.first != 0 && block.uniform == 0) {
    coder.bit(models_.on_surface[0][token.choice_context], token.choice == 1);
    if (token.choice != 1 && block.label.second != 0) {
      coder.bit(models_.on_surface[1][token.choice_context], token.choice == 2);
    }
  }
  if (token.choice != 0 || block.corrected == 0) return;
  coder.bit(models_.correction[token.correction_context], token.correction != 0);
  if (token.correction == 0) return;
  coder.bit(models_.sign[token.sign_context], token.correction > 0);
  const int more = std::abs(int{token.correction}) - 1;
  BitModel* unary = models_.magnitude[token.magnitude_context];
  for (int i = 0; i < kMaxUnary; ++i) {
    coder.bit(unary[i], more > i);
    if (more <= i) return;
  }
  const auto distance = static_cast<std::uint32_t>(token.jump);
  const int length = static_cast<int>(std::bit_width(distance));
  code_tree(coder, models_.jump_length, kJumpBits, static_cast<std::uint32_t>(length));
  if (length == 0) {
    coder.raw(token.raw_depth, 16);
  } else if (length > 1) {
    coder.bit(models_.jump_top[length], ((distance >> (length - 2)) & 1U) != 0);
    if (length > 2) coder.raw(distance & ((1U << (length - 2)) - 1U), length - 2);
  }
}

Status TilePacker::pack_verbatim(const CodingTables& tables, const FrameModel& frame,
                                 const TileRect& rect, std::span<std::uint8_t> out,
                                 TileReport& report) noexcept {
  const TileSpan span = tile_span(tables.config->camera, rect);
  RangeEncoder coder(out);
  coder.raw(kVerbatim, 1);
  code_rect(coder, tables.config->camera, rect);
  report = {};
  report.verbatim = true;
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
