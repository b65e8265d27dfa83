// Pixels under a bound: quantised in the decoder's own arithmetic, into decisions.
#include <algorithm>
#include <bit>
#include <cstdlib>

#include "core/wire/correction_search.hpp"
#include "core/wire/tile_pack.hpp"
#include "core/wire/tile_pack_job.hpp"

namespace planecast {

void TilePacker::quantise_bounded_row(Job& job, std::uint32_t v) noexcept {
  const std::uint32_t tile_v = v - job.span.v0, y = tile_v % 8;
  const TileRows rows(rows_, tile_v);
  const std::uint16_t* const depths = job.depths(v);
  std::uint32_t* const ends = ends_.data() + std::size_t{y} * job.rect.bw;
  BlockState* const blocks = blocks_at(job, v);
  for (std::uint32_t i = 0; i < job.rect.bw; ++i) {
    const std::uint32_t x0 = i * 8, x1 = std::min(x0 + 8, job.span.u1 - job.span.u0);
    const std::size_t at = x0 + PixelRow::kBorder;
    BlockState& block = blocks[i];
    if (block.any == 0) {
      rows.here.clear(x0, x1);
    } else if (block.flat != 0) {
      keep_flat(rows.here, at, surfaces_[i], y, x1 - x0, job.last_level);
      if (block.full != 0) {
        job.fallback = rows.here.level[at + x1 - x0 - 1];
      } else {
        quantise_holes(job, rows, x0, x1, depths);
      }
    } else {
      const std::uint8_t ray_class =
          job.tables.bounds->ray_class(job.rect.bx + i, job.rect.by + tile_v / 8);
      const BlockSurface* const surface = block.label.first != 0 ? &surfaces_[i] : nullptr;
      quantise_bounded(job, rows, {block, surface, ray_class, x0, x1, v, depths});
    }
    ends[i] = decided_;
  }
}

// Of a row of a flat block whose levels are all there: takes away those that are holes.
void TilePacker::quantise_holes(Job& job, const TileRows rows, std::uint32_t x0, std::uint32_t x1,
                                const std::uint16_t* depths) noexcept {
  std::uint16_t* const level = rows.here.level + x0 + PixelRow::kBorder;
  MaskWalk mask = rows.mask(x0);
  PixelDecision* const out = decisions_.data() + decided_;
  unsigned readings = 0;
  for (std::uint32_t x = 0; x < x1 - x0; ++x) {
    const bool reading = depths[x0 + x] != 0;
    out[x] = mask_decision(mask.context(), reading);
    mask.step(reading);
    readings |= static_cast<unsigned>(reading) << x;
  }
  decided_ += x1 - x0;
  if (readings != 0) job.fallback = level[std::bit_width(readings) - 1];
  store8(level, load8(level) & lanes_of8(readings));
}

void TilePacker::quantise_bounded(Job& job, const TileRows rows, const Segment& segment) noexcept {
  if (segment.surface == nullptr) {
    quantise_segment<SegmentKind::kPlain>(job, rows, segment);
  } else if (job.surfaces_kind) {
    quantise_segment<SegmentKind::kChoosing>(job, rows, segment);
  } else {
    quantise_segment<SegmentKind::kOnSurface>(job, rows, segment);
  }
}

// What the loop uses is copied first: a store of a byte may change anything in memory, as far as a
// compiler knows, and would have all of it read again. One loop for each kind of block: what a kind
// has no use for keeps no register.
template <TilePacker::SegmentKind kKind>
void TilePacker::quantise_segment(Job& job, const TileRows rows, const Segment& segment) noexcept {
  constexpr bool kChoosing = kKind == SegmentKind::kChoosing;
  PixelPlace place = segment.place(job);
  place.has_surface = kKind != SegmentKind::kPlain;
  const bool full = segment.block.full != 0;
  const LevelWindow* const windows = job.tables.bounds->windows(segment.ray_class);
  const std::uint16_t* const depths = segment.row;
  PixelDecision* out = decisions_.data() + decided_;
  std::int32_t fallback = job.fallback;
  std::uint32_t corrections = 0;
  bool uniform = true;
  MaskWalk mask = rows.mask(segment.x0);
  for (std::uint32_t x = segment.x0; x < segment.x1; ++x, place.step_right()) {
    const Neighbourhood around = rows.around(x);
    const std::uint16_t depth = depths[x];
    if (!full) {
      *out++ = mask_decision(mask.context(), depth != 0);
      mask.step(depth != 0);
    }
    if (depth == 0) {
      rows.here.set_hole(around.at);
      continue;
    }
    if constexpr (kChoosing) {
      const std::uint8_t context = choice_context(around);
      const PixelKind on = choose_surface(job, segment, x, depth, rows.here);
      uniform &= on == PixelKind::kFirstSurface;
      *out++ = choice_decision(0, context, on == PixelKind::kFirstSurface);
      if (on != PixelKind::kFirstSurface && segment.block.label.second != 0)
        *out++ = choice_decision(1, context, on == PixelKind::kSecondSurface);
      if (on != PixelKind::kPredicted) {
        fallback = rows.here.level[around.at];
        continue;
      }
    }
    const PixelPrediction p = predict_pixel(around, place, fallback);
    const int activity = pixel_activity(around, p);
    const std::uint16_t context = correction_context(around, activity);
    const LevelWindow window = windows[depth];
    if (p.level >= window.low && p.level <= window.high) [[likely]] {
      *out++ = correction_decision(context, false);
      keep_predicted(rows.here, around.at, p);
      fallback = p.level;
      continue;
    }
    *out++ = correction_decision(context, true);
    const PixelPrediction away = p;  // only this copy leaves the registers
    const Correction found =
        find_correction(*job.tables.levels, away, depth, window, place.last_level);
    if (std::abs(found.steps) > kMaxUnary) jumps_[jumps_in_++] = {found.jump, depth};
    out = add_correction(out, sign_context(around, p), magnitude_context(around, activity),
                         found.steps);
    keep_corrected(rows.here, around.at, p, found.level, found.steps);
    fallback = found.level;
    ++corrections;
  }
  decided_ = static_cast<std::uint32_t>(out - decisions_.data());
  if (corrections != 0) segment.block.corrected = 1;
  if (!uniform) segment.block.uniform = 0;
  job.corrections += corrections;
  job.fallback = fallback;
}

// The surface of its block that holds a reading, kPredicted when none does.
TilePacker::PixelKind TilePacker::choose_surface(const Job& job, const Segment& segment,
                                                 std::uint32_t x, std::uint16_t depth,
                                                 PixelRow& row) const noexcept {
  const std::uint32_t limit = job.tables.bounds->max_error(depth, segment.ray_class);
  const std::uint32_t u = job.span.u0 + x;
  const std::int32_t rx = job.tables.rays->x(u, segment.v), ry = job.tables.rays->y(u, segment.v);
  for (const bool second : {false, true}) {
    const std::uint8_t label = second ? segment.block.label.second : segment.block.label.first;
    if (label == 0) break;
    const std::uint16_t on = surface_depth(job.surface(label), rx, ry);
    if (on == 0 || static_cast<std::uint32_t>(std::abs(int{on} - int{depth})) > limit) continue;
    keep_chosen(row, x + PixelRow::kBorder, job.tables.levels->nearest(on), second ? 2 : 1);
    return second ? PixelKind::kSecondSurface : PixelKind::kFirstSurface;
  }
  return PixelKind::kPredicted;
}

}  // namespace planecast
