// The entropy coding of a tile whose pixels are quantised: block decisions, then pixels.
#include <algorithm>
#include <bit>
#include <cstdlib>

#include "core/wire/tile_pack.hpp"
#include "core/wire/tile_pack_job.hpp"
#include "core/wire/tile_write.hpp"

namespace planecast {

void TilePacker::code_block(const Job& job, RangeEncoder& coder, const BlockState& block,
                            const BlockNeighbours& n, const FlatChoice& flat) noexcept {
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
  if (may_be_flat(job.tables, block)) {
    coder.bit(models_.block_flat[flat_context(n, block)], block.flat != 0);
    if (block.flat != 0) {
      code_plane(coder, models_, flat.contexts, flat.code);
      return;
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
  code_jump(coder, jumps_[jumps_out_++]);
}

void TilePacker::code_jump(RangeEncoder& coder, const Jump& jump) noexcept {
  const auto distance = static_cast<std::uint32_t>(std::abs(jump.levels));
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
                i > 0 && above != nullptr ? &above[i - 1] : nullptr},
               flats_[i]);
  }
  const std::uint32_t begin = job.span.v0 + row * 8;
  const std::uint32_t rows = std::min(begin + 8, job.span.v1) - begin;
  const std::uint32_t columns = job.span.u1 - job.span.u0;
  const bool lossless = job.tables.bounds->lossless();
  const bool every_count = job.tables.levels->every_count();
  for (std::uint32_t y = 0; y < rows; ++y) {
    const Token* tokens = tokens_.data() + std::size_t{y} * job.rect.bw * 8;
    for (std::uint32_t i = 0; i < job.rect.bw; ++i) {
      const BlockState& block = blocks[i];
      // Nothing to say of most pixels.
      const bool mixed = job.surfaces_kind && block.label.first != 0 && block.uniform == 0;
      if (lossless && block.any != 0) {
        const Residual* found = found_.data() + (std::size_t{y} * job.rect.bw + i) * 8;
        const std::uint32_t count = std::min(8U, columns - i * 8);
        if (every_count) {
          code_residuals<true>(coder, block, found, count);
        } else {
          code_residuals<false>(coder, block, found, count);
        }
        continue;
      }
      if (block.any == 0 || (block.full != 0 && block.corrected == 0 && !mixed)) continue;
      for (std::uint32_t x = i * 8; x < std::min(i * 8 + 8, columns); ++x) {
        code_pixel(job, coder, block, tokens[x]);
      }
    }
  }
  jumps_in_ = jumps_out_ = 0;
  shared = coder;
}

}  // namespace planecast
