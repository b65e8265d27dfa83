#include "core/wire/tile_pack.hpp"

#include <algorithm>
#include <bit>
#include <cstdlib>

#include "core/wire/tile_write.hpp"

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

// Eight pixels of one row, within one block.
struct TilePacker::Segment {
  BlockState& block;
  PixelPlace place;  ///< of the current pixel
  std::uint8_t ray_class;
  std::uint32_t x0, x1;      ///< columns within the tile
  std::uint32_t v;           ///< row of the image
  const std::uint16_t* row;  ///< counts of the tile's row
  Token* tokens;             ///< of the tile's row
};

void TilePacker::layout(Arena& arena, std::uint32_t max_width) noexcept {
  const std::uint32_t blocks = std::min<std::uint32_t>((max_width + 7) / 8, kMaxTileBlocks);
  rows_ = arena.take<PixelRow>(3);
  tokens_ = arena.take<Token>(std::size_t{blocks} * 64);
  jumps_ = arena.take<Jump>(std::size_t{blocks} * 64);
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
  jumps_in_ = jumps_out_ = 0;
  code_head(job, coder);
  clear_rows(rows_, rect.bw);
  for (std::uint32_t row = 0; row < rect.bh && !coder.overflow(); ++row) {
    open_block_row(job, row);
    const std::uint32_t begin = job.span.v0 + row * 8;
    for (std::uint32_t v = begin; v < std::min(begin + 8, job.span.v1); ++v) quantise_row(job, v);
    code_block_row(job, coder, row);
  }
  const std::size_t used = coder.finish();
  if (coder.overflow()) return store(tables, frame, rect, out, report);
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
  const TileRows rows(rows_, tile_v);
  const std::uint16_t* row = &job.frame.depth[std::size_t{v} * job.width() + job.span.u0];
  Token* tokens = tokens_.data() + std::size_t{tile_v % 8} * job.rect.bw * 8;
  BlockState* blocks = blocks_.data() + ((tile_v / 8) & 1U) * job.rect.bw;
  for (std::uint32_t i = 0; i < job.rect.bw; ++i) {
    const std::uint32_t x0 = i * 8, x1 = std::min(x0 + 8, job.span.u1 - job.span.u0);
    if (blocks[i].any == 0) {
      rows.here.clear(x0, x1);
      continue;
    }
    const BoundTable& bounds = *job.tables.bounds;
    const std::uint8_t ray_class = bounds.ray_class(job.rect.bx + i, job.rect.by + tile_v / 8);
    Segment segment{blocks[i], {}, ray_class, x0, x1, v, row, tokens};
    segment.place = PixelPlace(bounds.half_widths(ray_class), job.last_level);
    if (blocks[i].label.first != 0) segment.place.lie_on(surfaces_[i], tile_v % 8);
    quantise_segment(job, rows, segment);
  }
}

// What the loop uses is copied first: a store of a byte may change anything in memory, as far as a
// compiler knows, and would have all of it read again.
void TilePacker::quantise_segment(Job& job, const TileRows rows, const Segment& segment) noexcept {
  PixelPlace place = segment.place;
  const bool choosing = job.surfaces_kind && place.has_surface;
  const bool full = segment.block.full != 0;
  const LevelTable levels = *job.tables.levels;
  const BoundTable& bounds = *job.tables.bounds;
  const std::uint8_t ray_class = segment.ray_class;
  const std::uint16_t* const depths = segment.row;
  Token* const tokens = segment.tokens;
  std::int32_t fallback = job.fallback;
  std::uint32_t corrections = 0;
  bool uniform = true;
  for (std::uint32_t x = segment.x0; x < segment.x1; ++x, place.step_right()) {
    const Neighbourhood around = rows.around(x);
    const std::uint16_t depth = depths[x];
    Token token;
    if (!full) token.mask_context = mask_context(around);
    if (depth == 0) {
      rows.here.set_hole(around.at);
      tokens[x] = token;
      continue;
    }
    if (choosing) token.choice_context = choice_context(around);
    if (!choosing || !choose_surface(job, segment, x, depth, token, rows.here)) {
      const PixelPrediction p = predict_pixel(around, place, fallback);
      const int activity = pixel_activity(around, p);
      token.kind = PixelKind::kPredicted;
      token.correction_context = correction_context(around, activity);
      const std::uint32_t limit = bounds.max_error(depth, ray_class);
      const auto at = static_cast<std::uint32_t>(p.level);
      if (static_cast<std::uint32_t>(std::abs(int{levels.depth(at)} - int{depth})) <= limit) {
        keep_predicted(rows.here, around.at, p);
      } else {
        const std::int32_t level = correct(job, p, depth, limit, token);
        token.sign_context = sign_context(around, p);
        token.magnitude_context = magnitude_context(around, activity);
        keep_corrected(rows.here, around.at, p, level, token.correction);
        ++corrections;
      }
    }
    uniform &= token.kind == PixelKind::kFirstSurface;
    fallback = rows.here.level[around.at];
    tokens[x] = token;
  }
  if (corrections != 0) segment.block.corrected = 1;
  if (!uniform) segment.block.uniform = 0;
  job.corrections += corrections;
  job.fallback = fallback;
}

bool TilePacker::choose_surface(const Job& job, const Segment& segment, std::uint32_t x,
                                std::uint16_t depth, Token& token, PixelRow& row) const noexcept {
  const std::uint32_t limit = job.tables.bounds->max_error(depth, segment.ray_class);
  const std::uint32_t u = job.span.u0 + x;
  const std::int32_t rx = job.tables.rays->x(u, segment.v), ry = job.tables.rays->y(u, segment.v);
  for (const bool second : {false, true}) {
    const std::uint8_t label = second ? segment.block.label.second : segment.block.label.first;
    if (label == 0) break;
    const std::uint16_t on = surface_depth(job.surface(label), rx, ry);
    if (on == 0 || static_cast<std::uint32_t>(std::abs(int{on} - int{depth})) > limit) continue;
    token.kind = second ? PixelKind::kSecondSurface : PixelKind::kFirstSurface;
    keep_chosen(row, x + PixelRow::kBorder, job.tables.levels->nearest(on), second ? 2 : 1);
    return true;
  }
  return false;
}

// The correction of a reading that its prediction does not hold; returns the level it leads to.
std::int32_t TilePacker::correct(const Job& job, const PixelPrediction& p, std::uint16_t depth,
                                 std::uint32_t limit, Token& token) noexcept {
  const LevelTable& levels = *job.tables.levels;
  const auto within = [&](std::int32_t level) {
    return static_cast<std::uint32_t>(std::abs(
               int{levels.depth(static_cast<std::uint32_t>(level))} - int{depth})) <= limit;
  };
  const std::int32_t own = levels.nearest(depth);
  const bool up =
      own > p.level || (own == p.level && depth > levels.depth(static_cast<std::uint32_t>(own)));
  const int sign = up ? 1 : -1;
  const std::int32_t step = p.step();
  // The first step whose window may hold the reading, and the two after it.
  const std::int32_t least = std::abs(own - p.level) - 2 * p.half_width;
  const std::int32_t first = least < 2 * step ? 1 : least / step;
  for (std::int32_t n = first; n <= first + 3 && n <= kMaxUnary; ++n) {
    const std::int32_t level = p.level + sign * n * step;
    if (level < 1 || level > job.last_level) break;
    if (!within(level)) continue;
    token.correction = static_cast<std::int8_t>(sign * n);
    return level;
  }
  token.correction = static_cast<std::int8_t>(sign * (kMaxUnary + 1));
  const bool near_own = within(own);
  jumps_[jumps_in_++] = {near_own ? std::abs(own - p.level) : 0, depth};
  return own;
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

[[gnu::always_inline]] inline void TilePacker::code_correction(RangeEncoder& coder,
                                                               const Token& token) noexcept {
  coder.bit(models_.sign[token.sign_context], token.correction > 0);
  const int more = std::abs(int{token.correction}) - 1;
  BitModel* unary = models_.magnitude[token.magnitude_context];
  for (int i = 0; i < kMaxUnary; ++i) {
    coder.bit(unary[i], more > i);
    if (more <= i) return;
  }
  const Jump jump = jumps_[jumps_out_++];
  const auto distance = static_cast<std::uint32_t>(jump.levels);
  const int length = static_cast<int>(std::bit_width(distance));
  code_tree(coder, models_.jump_length, kJumpBits, static_cast<std::uint32_t>(length));
  if (length == 0) {
    coder.raw(jump.raw_depth, 16);
  } else if (length > 1) {
    coder.bit(models_.jump_top[length], ((distance >> (length - 2)) & 1U) != 0);
    if (length > 2) coder.raw(distance & ((1U << (length - 2)) - 1U), length - 2);
  }
}

[[gnu::always_inline]] inline void TilePacker::code_pixel(const Job& job, RangeEncoder& coder,
                                                          const BlockState& block,
                                                          const Token& token) noexcept {
  const bool reading = token.kind != PixelKind::kHole;
  if (block.full == 0) coder.bit(models_.mask[token.mask_context], reading);
  if (!reading) return;
  if (job.surfaces_kind && block.label.first != 0 && block.uniform == 0) {
    const bool first = token.kind == PixelKind::kFirstSurface;
    coder.bit(models_.on_surface[0][token.choice_context], first);
    if (!first && block.label.second != 0) {
      coder.bit(models_.on_surface[1][token.choice_context],
                token.kind == PixelKind::kSecondSurface);
    }
  }
  if (token.kind != PixelKind::kPredicted || block.corrected == 0) return;
  coder.bit(models_.correction[token.correction_context], token.correction != 0);
  if (token.correction != 0) code_correction(coder, token);
}

void TilePacker::code_block_row(Job& job, RangeEncoder& shared, std::uint32_t row) noexcept {
  RangeEncoder coder = shared;  // a copy stays in registers
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
    for (std::uint32_t i = 0; i < job.rect.bw; ++i) {
      const BlockState& block = blocks[i];
      // Nothing to say of most pixels.
      const bool mixed = job.surfaces_kind && block.label.first != 0 && block.uniform == 0;
      if (block.any == 0 || (block.full != 0 && block.corrected == 0 && !mixed)) continue;
      for (std::uint32_t x = i * 8; x < std::min(i * 8 + 8, columns); ++x) {
        code_pixel(job, coder, block, tokens[x]);
      }
    }
  }
  jumps_in_ = jumps_out_ = 0;
  shared = coder;
}

Status TilePacker::store(const CodingTables& tables, const FrameModel& frame, const TileRect& rect,
                         std::span<std::uint8_t> out, TileReport& report) noexcept {
  const TileSpan span = tile_span(tables.config->camera, rect);
  RangeEncoder coder(out);
  coder.raw(kVerbatimTile, 1);
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
