// Rows of tiles under a bound: flat blocks, and pixels of which few need a correction.
#include <algorithm>
#include <bit>

#include "core/wire/tile_read.hpp"
#include "core/wire/tile_unpack.hpp"
#include "core/wire/tile_unpack_job.hpp"

namespace planecast {

Status TileUnpacker::read_row(Job& job, RangeDecoder& coder, std::uint32_t tile_v) noexcept {
  const TileRows rows(rows_, tile_v);
  const std::size_t begin = std::size_t{job.span.v0 + tile_v} * job.width() + job.span.u0;
  std::uint16_t* depth = job.target.depth.data() + begin;
  std::uint8_t* labels = job.target.labels.empty() ? nullptr : job.target.labels.data() + begin;
  const BlockState* blocks = blocks_.data() + ((tile_v / 8) & 1U) * job.rect().bw;
  for (std::uint32_t i = 0; i < job.rect().bw; ++i) {
    const std::uint32_t x0 = i * 8, x1 = std::min(x0 + 8, job.span.u1 - job.span.u0);
    if (blocks[i].any == 0) {
      rows.here.clear(x0, x1);
      std::fill(depth + x0, depth + x1, std::uint16_t{0});
      if (labels != nullptr) std::fill(labels + x0, labels + x1, std::uint8_t{0});
      continue;
    }
    if (blocks[i].flat != 0) {
      read_flat(job, coder, rows,
                {blocks[i], &surfaces_[i], nullptr, x0, x1, tile_v, depth, labels});
      continue;
    }
    const BoundTable& bounds = *job.tables.bounds;
    const std::uint8_t ray_class = bounds.ray_class(job.rect().bx + i, job.rect().by + tile_v / 8);
    const BlockSurface* const surface = blocks[i].label.first != 0 ? &surfaces_[i] : nullptr;
    const Segment segment{blocks[i], surface, bounds.half_widths(ray_class),
                          x0,        x1,      job.span.v0 + tile_v,
                          depth,     labels};
    if (!read_segment(job, coder, rows, segment)) return Status::kBadSymbol;
  }
  return Status::kOk;
}

// A row of a flat block: only holes are coded.
void TileUnpacker::read_flat(Job& job, RangeDecoder& shared, const TileRows rows,
                             const Segment& segment) noexcept {
  const std::size_t at = segment.x0 + PixelRow::kBorder;
  const std::uint32_t columns = segment.x1 - segment.x0;
  const LevelTable& levels = *job.tables.levels;
  keep_flat(rows.here, at, *segment.surface, segment.v % 8, columns, job.last_level);
  std::uint16_t* const level = rows.here.level + at;
  std::uint16_t* const depth = segment.depth + segment.x0;
  if (segment.block.full != 0) {
    job.fallback = level[columns - 1];
    job.content.points += columns;
    levels.depths(level, columns, depth);
  } else {
    MaskWalk mask = rows.mask(segment.x0);
    RangeDecoder coder = shared;
    unsigned readings = 0;
    for (std::uint32_t x = 0; x < columns; ++x) {
      readings |= static_cast<unsigned>(read_mask(coder, mask)) << x;
    }
    shared = coder;
    if (readings != 0) job.fallback = level[std::bit_width(readings) - 1];
    store8(level, load8(level) & lanes_of8(readings));
    job.content.points += static_cast<std::uint32_t>(std::popcount(readings));
    levels.depths(level, columns, depth);
  }
  if (segment.labels == nullptr) return;
  if (segment.block.full != 0) {
    std::fill_n(segment.labels + segment.x0, columns, segment.block.label.first);
    return;
  }
  for (std::uint32_t x = 0; x < columns; ++x)
    segment.labels[segment.x0 + x] = level[x] != 0 ? segment.block.label.first : std::uint8_t{0};
}

// True when the pixel is on one of its block's surfaces; says which.
[[gnu::always_inline]] inline bool TileUnpacker::read_choice(RangeDecoder& coder,
                                                             const Neighbourhood& around,
                                                             const BlockState& block,
                                                             std::uint8_t& choice) noexcept {
  choice = 1;
  if (block.uniform == 0) {
    const int context = choice_context(around);
    choice = coder.bit(models_.on_surface[0][context]) ? 1 : 0;
    if (choice == 0 && block.label.second != 0) {
      choice = coder.bit(models_.on_surface[1][context]) ? 2 : 0;
    }
  }
  return choice != 0;
}

[[gnu::noinline]] TileUnpacker::Corrected TileUnpacker::read_correction(const LevelTable& levels,
                                                                        RangeDecoder& coder,
                                                                        const Neighbourhood around,
                                                                        const PixelPrediction& p,
                                                                        int activity) noexcept {
  const int sign = coder.bit(models_.sign[sign_context(around, p)]) ? 1 : -1;
  BitModel* const unary = models_.magnitude[magnitude_context(around, activity)];
  int more = 0;
  while (more < kMaxUnary && coder.bit(unary[more])) ++more;
  Corrected out;
  out.correction = sign * (more + 1);
  out.level = more < kMaxUnary ? p.level + out.correction * p.step()
                               : read_jump(levels, coder, p.level, sign, out.raw);
  return out;
}

// False for a value that no encoder writes. What the loop uses is copied first: a store of a byte
// may change anything in memory, as far as a compiler knows, and would have all of it read again.
bool TileUnpacker::read_segment(Job& job, RangeDecoder& shared, const TileRows rows,
                                const Segment& segment) noexcept {
  RangeDecoder coder = shared;
  PixelPlace place(segment.half_widths, job.last_level);
  if (segment.surface != nullptr) place.lie_on(*segment.surface, segment.v % 8);
  const BlockState block = segment.block;
  const bool choosing = job.surfaces_kind && place.has_surface;
  const std::uint8_t plain_label = job.surfaces_kind ? std::uint8_t{0} : block.label.first;
  const LevelTable levels = *job.tables.levels;
  std::uint16_t* const depths = segment.depth;
  std::uint8_t* const labels = segment.labels;
  std::int32_t fallback = job.fallback;
  std::uint32_t points = 0, corrections = 0;
  MaskWalk mask = rows.mask(segment.x0);
  for (std::uint32_t x = segment.x0; x < segment.x1; ++x, place.step_right()) {
    const Neighbourhood around = rows.around(x);
    std::uint16_t depth = 0;
    std::uint8_t label = 0, choice = 0;
    if (block.full == 0 && !read_mask(coder, mask)) {
      rows.here.set_hole(around.at);
    } else if (choosing && read_choice(coder, around, block, choice)) {
      label = choice == 1 ? block.label.first : block.label.second;
      depth = surface_depth(job.surfaces[label], job.tables.rays->x(job.span.u0 + x, segment.v),
                            job.tables.rays->y(job.span.u0 + x, segment.v));
      if (depth == 0) return false;
      fallback = levels.nearest(depth);
      keep_chosen(rows.here, around.at, fallback, choice);
      ++points;
    } else {
      const PixelPrediction p = predict_pixel(around, place, fallback);
      const int activity = block.corrected != 0 ? pixel_activity(around, p) : 0;
      if (block.corrected != 0 &&
          coder.bit(models_.correction[correction_context(around, activity)])) [[unlikely]] {
        RangeDecoder away = coder;  // only this copy leaves the registers
        const Corrected found = read_correction(levels, away, around, p, activity);
        coder = away;
        fallback = found.level;
        depth = found.raw;
        if (fallback < 1 || fallback > place.last_level) return false;
        keep_corrected(rows.here, around.at, p, fallback, found.correction);
        ++corrections;
      } else {
        fallback = p.level;
        keep_predicted(rows.here, around.at, p);
      }
      if (depth == 0) [[likely]]
        depth = levels.depth(static_cast<std::uint32_t>(fallback));
      label = plain_label;
      ++points;
    }
    depths[x] = depth;
    if (labels != nullptr) labels[x] = label;
  }
  job.fallback = fallback;
  job.content.points += points;
  job.content.corrections += corrections;
  shared = coder;
  return true;
}

}  // namespace planecast
