// Rows of lossless tiles: residuals as symbols.
#include <algorithm>

#include "core/wire/tile_read.hpp"
#include "core/wire/tile_unpack.hpp"
#include "core/wire/tile_unpack_job.hpp"

namespace planecast {

// The level of a pixel that is far from its prediction, 0 for one that is none; `depth` becomes its
// count when that is off the levels.
[[gnu::noinline]] std::int32_t TileUnpacker::read_far(const LevelTable& levels, RangeDecoder& coder,
                                                      std::int32_t prediction,
                                                      std::uint16_t& depth) noexcept {
  const std::int32_t sign = coder.raw(1) != 0 ? -1 : 1;
  return read_jump(levels, coder, prediction, sign, depth);
}

// What the loop uses is copied first, as in read_segment().
template <bool kEveryCount>
Status TileUnpacker::read_lossless_row(Job& job, RangeDecoder& shared,
                                       std::uint32_t tile_v) noexcept {
  RangeDecoder coder = shared;
  const TileRows rows(rows_, tile_v);
  const std::size_t begin = std::size_t{job.span.v0 + tile_v} * job.width() + job.span.u0;
  std::uint16_t* const depths = job.target.depth.data() + begin;
  std::uint8_t* const labels =
      job.target.labels.empty() ? nullptr : job.target.labels.data() + begin;
  const BlockState* blocks = blocks_.data() + ((tile_v / 8) & 1U) * job.rect().bw;
  const LevelTable levels = *job.tables.levels;
  const std::uint8_t* const no_widths = job.tables.bounds->half_widths(0);  // zeros
  const std::int32_t last_level = job.last_level;
  std::int32_t fallback = job.fallback;
  std::uint32_t points = 0, corrections = 0;
  for (std::uint32_t i = 0; i < job.rect().bw; ++i) {
    const std::uint32_t x0 = i * 8, x1 = std::min(x0 + 8, job.span.u1 - job.span.u0);
    const BlockState block = blocks[i];
    if (block.any == 0) rows.here.clear(x0, x1);
    if (labels != nullptr) std::fill(labels + x0, labels + x1, block.label.first);
    if (block.any == 0) {
      std::fill(depths + x0, depths + x1, std::uint16_t{0});
      if (labels != nullptr) std::fill(labels + x0, labels + x1, std::uint8_t{0});
      continue;
    }
    PixelPlace place(no_widths, last_level);
    if (block.label.first != 0) place.lie_on(surfaces_[i], tile_v % 8);
    MaskWalk mask = rows.mask(x0);
    for (std::uint32_t x = x0; x < x1; ++x, place.step_right()) {
      const Neighbourhood around = rows.around(x);
      if (block.full == 0 && !read_mask(coder, mask)) {
        rows.here.set_hole(around.at);
        depths[x] = 0;
        if (labels != nullptr) labels[x] = 0;
        continue;
      }
      ++points;
      const LosslessPrediction p = predict_lossless(around, place, fallback, kEveryCount);
      std::int32_t level = p.level;
      std::uint16_t depth = 0;
      if (block.corrected != 0) {
        const ResidualContext context = residual_context(around, p);
        SymbolModel& by_shape = residuals_.shape[context.shape];
        int symbol;
        if constexpr (kEveryCount) {
          const std::uint32_t errors = errors_context(around, p, context);
          symbol = coder.symbol(SymbolPair(by_shape, residuals_.errors[errors]));
        } else {
          symbol = coder.symbol(by_shape);
        }
        corrections += symbol != 0;
        if (symbol != kFarSymbol) [[likely]] {
          std::int32_t size = residual_base(symbol);
          if (symbol > 8) [[unlikely]]
            size += static_cast<std::int32_t>(coder.raw(residual_bits(symbol)));
          const std::int32_t below = ((symbol & 1) - 1) ^ context.turned;  // -1: downwards
          level += (size ^ below) - below;
        } else {
          RangeDecoder away = coder;  // only this copy leaves the registers
          level = read_far(levels, away, p.level, depth);
          coder = away;
        }
        if (level < 1 || level > last_level) return Status::kBadSymbol;
      }
      keep_residual(rows.here, around.at, p, level);
      fallback = level;
      depths[x] = depth != 0 ? depth : levels.depth(static_cast<std::uint32_t>(level));
    }
  }
  job.fallback = fallback;
  job.content.points += points;
  job.content.corrections += corrections;
  shared = coder;
  return Status::kOk;
}

template Status TileUnpacker::read_lossless_row<false>(Job&, RangeDecoder&, std::uint32_t) noexcept;
template Status TileUnpacker::read_lossless_row<true>(Job&, RangeDecoder&, std::uint32_t) noexcept;

}  // namespace planecast
