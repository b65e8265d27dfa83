// Lossless tiles: residuals as symbols. Every level is known beforehand, so that no pixel waits for
// the one before it.
#include <algorithm>
#include <cstdlib>

#include "core/base/lanes.hpp"
#include "core/wire/tile_pack.hpp"
#include "core/wire/tile_pack_job.hpp"

namespace planecast {
namespace {

// Levels up to this can be added and taken from each other in sixteen bits.
constexpr std::int32_t kMostShortLevel = 16383;

// detail::LevelsAround of the eight pixels of a segment, of a stream whose levels are a lattice.
struct EightAround {
  std::int16_t neighbour[8], apart[8], slopes[8];

  LosslessPrediction predict(const Neighbourhood& n, const PixelPlace& place,
                             std::uint32_t i) const noexcept {
    return {predict_from(n, place, neighbour[i]), apart[i], slopes[i]};
  }
};

// detail::slope_grade() of eight; what is true is -1.
Short8 slope_grades(Short8 d) noexcept {
  return (d < 0) + (d < -1) + (d < -3) - (d > 0) - (d > 1) - (d > 3);
}

// detail::levels_around() of eight pixels from index `at`; false where a hole is among what they
// see.
bool levels_around_eight(const PixelRow& here, const PixelRow& above, std::size_t at,
                         EightAround& out) noexcept {
  const auto left = load8(here.level + at - 1), up = load8(above.level + at);
  const auto corner = load8(above.level + at - 1), right = load8(above.level + at + 1);
  if ((nonzero_bits8(left) & nonzero_bits8(up) & nonzero_bits8(right)) != 0xffU ||
      above.level[at - 1] == 0)
    return false;
  const auto l = reinterpret_cast<Short8>(left), u = reinterpret_cast<Short8>(up);
  const auto ul = reinterpret_cast<Short8>(corner), ur = reinterpret_cast<Short8>(right);
  const auto size = [](Short8 a) { return max8(a, -a); };
  store8(out.neighbour, max8(min8(l, u), min8(l + u - ul, max8(l, u))));
  store8(out.apart, size(l - ul) + size(u - ul) + size(ur - u));
  store8(out.slopes, 49 * slope_grades(l - ul) + 7 * slope_grades(u - ul) + slope_grades(ur - u));
  return true;
}

}  // namespace

void TilePacker::quantise_lossless_row(Job& job, std::uint32_t v) noexcept {
  const std::uint32_t tile_v = v - job.span.v0;
  const TileRows rows(rows_, tile_v);
  BlockState* const blocks = blocks_at(job, v);
  Residual* const residuals = found_.data() + std::size_t{tile_v % 8} * job.rect.bw * 8;
  for (std::uint32_t i = 0; i < job.rect.bw; ++i) {
    const std::uint32_t x0 = i * 8, x1 = std::min(x0 + 8, job.span.u1 - job.span.u0);
    if (blocks[i].any == 0) {
      rows.here.clear(x0, x1);
      continue;
    }
    const std::uint8_t ray_class =
        job.tables.bounds->ray_class(job.rect.bx + i, job.rect.by + tile_v / 8);
    const BlockSurface* const surface = blocks[i].label.first != 0 ? &surfaces_[i] : nullptr;
    const Segment segment{blocks[i], surface, ray_class, x0, x1, v, job.depths(v)};
    if (job.tables.levels->every_count()) {
      quantise_residuals<true>(job, rows, segment, residuals);
    } else {
      quantise_residuals<false>(job, rows, segment, residuals);
    }
  }
}

template <bool kEveryCount>
void TilePacker::quantise_residuals(Job& job, const TileRows rows, const Segment& segment,
                                    Residual* const residuals) noexcept {
  PixelPlace place = segment.place(job);
  const bool full = segment.block.full != 0;
  const LevelTable levels = *job.tables.levels;
  const std::uint16_t* const depths = segment.row;
  std::int32_t fallback = job.fallback;
  std::uint32_t corrections = 0;
  MaskWalk mask = rows.mask(segment.x0);
  const std::size_t at = segment.x0 + PixelRow::kBorder;
  for (std::uint32_t x = segment.x0; x < segment.x1; ++x)
    rows.here.level[x + PixelRow::kBorder] = levels.nearest(depths[x]);
  EightAround eight;
  const bool whole = !kEveryCount && segment.x1 - segment.x0 == 8 &&
                     job.last_level <= kMostShortLevel &&
                     levels_around_eight(rows.here, rows.above, at, eight);
  for (std::uint32_t x = segment.x0; x < segment.x1; ++x, place.step_right()) {
    const Neighbourhood around = rows.around(x);
    const std::uint16_t depth = depths[x];
    std::uint8_t in_mask = 0;
    if (!full) {
      in_mask = static_cast<std::uint8_t>(mask.context());
      mask.step(depth != 0);
    }
    if (depth == 0) {
      rows.here.set_hole(around.at);
      residuals[x] = Residual(in_mask);
      continue;
    }
    const LosslessPrediction p = whole ? eight.predict(around, place, x - segment.x0)
                                       : predict_lossless(around, place, fallback, kEveryCount);
    const ResidualContext context = residual_context(around, p);
    const std::int32_t level = rows.here.level[around.at];
    const std::int32_t residual = level - p.level;
    const std::int32_t turned = (residual ^ context.turned) - context.turned;
    const bool off_levels = levels.depth(static_cast<std::uint32_t>(level)) != depth;
    ResidualSymbol coded{kFarSymbol, 0};
    if (std::abs(residual) <= kMostNear && !off_levels) [[likely]] {
      coded = residual_symbol(turned);
    } else {
      jumps_[jumps_in_++] = {off_levels ? 0 : residual, depth};
    }
    const std::uint32_t errors = kEveryCount ? errors_context(around, p, context) : 0;
    residuals[x] = Residual(context.shape, errors, coded, in_mask);
    corrections += coded.symbol != 0;
    keep_residual(rows.here, around.at, p, level);
    fallback = level;
  }
  if (corrections != 0) segment.block.corrected = 1;
  job.corrections += corrections;
  job.fallback = fallback;
}

template <bool kEveryCount>
void TilePacker::code_residuals(RangeEncoder& coder, const BlockState& block,
                                const Residual* residuals, std::uint32_t count) noexcept {
  if (block.full != 0 && block.corrected == 0) return;
  for (std::uint32_t x = 0; x < count; ++x) {
    const Residual residual = residuals[x];
    if (block.full == 0) {
      coder.bit(models_.mask[residual.mask()], residual.reading());
      if (!residual.reading()) continue;
    }
    if (block.corrected == 0) continue;
    const int symbol = residual.symbol();
    SymbolModel& by_shape = residuals_.shape[residual.shape()];
    if constexpr (kEveryCount) {
      coder.symbol(SymbolPair(by_shape, residuals_.errors[residual.errors()]), symbol);
    } else {
      coder.symbol(by_shape, symbol);
    }
    if (symbol <= 8) [[likely]]
      continue;
    if (symbol != kFarSymbol) {
      coder.raw(residual.extra(), residual_bits(symbol));
      continue;
    }
    const Jump& jump = jumps_[jumps_out_++];
    coder.raw(jump.levels < 0 ? 1 : 0, 1);
    code_jump(coder, jump);
  }
}

void TilePacker::code_lossless_row(const Job& job, RangeEncoder& shared, const BlockState* blocks,
                                   std::uint32_t rows) noexcept {
  RangeEncoder coder = shared;
  const std::uint32_t columns = job.span.u1 - job.span.u0;
  const bool every_count = job.tables.levels->every_count();
  for (std::uint32_t y = 0; y < rows; ++y) {
    for (std::uint32_t i = 0; i < job.rect.bw; ++i) {
      if (blocks[i].any == 0) continue;
      const Residual* found = found_.data() + (std::size_t{y} * job.rect.bw + i) * 8;
      const std::uint32_t count = std::min(8U, columns - i * 8);
      if (every_count) {
        code_residuals<true>(coder, blocks[i], found, count);
      } else {
        code_residuals<false>(coder, blocks[i], found, count);
      }
    }
  }
  shared = coder;
}

}  // namespace planecast
