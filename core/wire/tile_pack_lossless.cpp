// Lossless tiles: residuals as symbols. Every level is known beforehand, so that no pixel waits for
// the one before it.
#include <cstdlib>

#include "core/wire/tile_pack.hpp"
#include "core/wire/tile_pack_job.hpp"

namespace planecast {

// A token's correction is the residual's symbol, its sign_context the bits after it.
void TilePacker::quantise_residuals(Job& job, const TileRows rows,
                                    const Segment& segment) noexcept {
  PixelPlace place = segment.place;
  const bool full = segment.block.full != 0;
  const LevelTable levels = *job.tables.levels;
  const std::uint16_t* const depths = segment.row;
  Token* const tokens = segment.tokens;
  std::int32_t fallback = job.fallback;
  std::uint32_t corrections = 0;
  MaskWalk mask = rows.mask(segment.x0);
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
      tokens[x] = {.mask_context = in_mask};
      continue;
    }
    const PixelPrediction p = predict_pixel(around, place, fallback);
    const ResidualContext context = residual_context(around, p.level);
    const std::int32_t level = levels.nearest(depth);
    const std::int32_t residual = level - p.level;
    const std::int32_t turned = (residual ^ context.turned) - context.turned;
    const bool off_levels = levels.depth(static_cast<std::uint32_t>(level)) != depth;
    ResidualSymbol symbol{kFarSymbol, 0};
    if (std::abs(residual) <= kMostNear && !off_levels) [[likely]] {
      symbol = residual_symbol(turned);
    } else {
      jumps_[jumps_in_++] = {off_levels ? 0 : residual, depth};
    }
    corrections += symbol.symbol != 0;
    keep_residual(rows.here, around.at, p, level);
    fallback = level;
    tokens[x] = {.correction_context = static_cast<std::uint16_t>(context.model),
                 .correction = static_cast<std::int8_t>(symbol.symbol),
                 .sign_context = symbol.extra,
                 .mask_context = in_mask,
                 .kind = PixelKind::kPredicted};
  }
  if (corrections != 0) segment.block.corrected = 1;
  job.corrections += corrections;
  job.fallback = fallback;
}

void TilePacker::code_residuals(RangeEncoder& coder, const BlockState& block, const Token* tokens,
                                std::uint32_t count) noexcept {
  if (block.full != 0 && block.corrected == 0) return;
  for (std::uint32_t x = 0; x < count; ++x) {
    const Token& token = tokens[x];
    const bool reading = token.kind != PixelKind::kHole;
    if (block.full == 0) {
      coder.bit(models_.mask[token.mask_context], reading);
      if (!reading) continue;
    }
    if (block.corrected == 0) continue;
    const int symbol = token.correction;
    coder.symbol(residuals_.of[token.correction_context], symbol);
    if (symbol <= 8) [[likely]]
      continue;
    if (symbol != kFarSymbol) {
      coder.raw(token.sign_context, residual_bits(symbol));
      continue;
    }
    const Jump& jump = jumps_[jumps_out_++];
    coder.raw(jump.levels < 0 ? 1 : 0, 1);
    code_jump(coder, jump);
  }
}

}  // namespace planecast
