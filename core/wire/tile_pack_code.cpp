// The entropy coding of a tile whose pixels are quantised: block decisions, then pixels.
#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdlib>

#include "core/wire/tile_pack.hpp"
#include "core/wire/tile_pack_job.hpp"
#include "core/wire/tile_write.hpp"

namespace planecast {

// Inlined, and so is what it calls often: the coder of the caller's loop stays in registers.
[[gnu::always_inline]] inline void TilePacker::code_block(const Job& job, RangeEncoder& coder,
                                                          const BlockState& block,
                                                          const BlockNeighbours& n,
                                                          const FlatChoice& flat) noexcept {
  const auto code_index = [&](std::uint8_t label) {
    RangeEncoder away = coder;  // only this copy leaves the registers
    code_tree(away, models_.label_index, kLabelBits, label);
    coder = away;
  };
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
        code_index(block.label.first);
      }
    }
    if (job.surfaces_kind && block.label.first != 0) {
      coder.bit(models_.block_second[0], block.label.second != 0);
      if (block.label.second != 0) code_index(block.label.second);
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

// Takes out what turned out to say nothing: of a block without corrections that there is none, of
// one on its first surface throughout which surface it is.
void TilePacker::drop_decisions(const Job& job, const BlockState* blocks,
                                std::uint32_t rows) noexcept {
  const auto whole = [&](const BlockState& block) {
    return block.any == 0 || block.flat != 0 ||
           (block.corrected != 0 && (!job.surfaces_kind || block.uniform == 0));
  };
  if (std::all_of(blocks, blocks + job.rect.bw, whole)) return;
  PixelDecision* to = decisions_.data();
  const PixelDecision* from = decisions_.data();
  for (std::uint32_t i = 0; i < rows * job.rect.bw; ++i) {
    const BlockState& block = blocks[i % job.rect.bw];
    const PixelDecision* const end = decisions_.data() + ends_[i];
    if (whole(block)) {
      to = std::copy(from, end, to);
    } else {
      to = std::copy_if(from, end, to, [&](PixelDecision d) {
        return (block.corrected != 0 || !is_correction(d)) && (block.uniform == 0 || !is_choice(d));
      });
    }
    from = end;
  }
  decided_ = static_cast<std::uint32_t>(to - decisions_.data());
}

void TilePacker::code_decisions(RangeEncoder& shared) noexcept {
  RangeEncoder coder = shared;  // a copy stays in registers
  auto* const models = reinterpret_cast<std::byte*>(&models_);
  const PixelDecision* const end = decisions_.data() + decided_;
  for (const PixelDecision* at = decisions_.data(); at != end; ++at) {
    const PixelDecision d = *at;
    if (d == kJumpFollows) [[unlikely]] {
      RangeEncoder away = coder;  // only this copy leaves the registers
      code_jump(away, jumps_[jumps_out_++]);
      coder = away;
      continue;
    }
    coder.bit(*reinterpret_cast<BitModel*>(models + (d & ~1U)), (d & 1U) != 0);
  }
  decided_ = 0;
  shared = coder;
}

void TilePacker::code_block_row(Job& job, RangeEncoder& shared, std::uint32_t row) noexcept {
  RangeEncoder coder = shared;
  const BlockState* blocks = blocks_.data() + (row & 1U) * job.rect.bw;
  const BlockState* above = row > 0 ? blocks_.data() + ((row + 1) & 1U) * job.rect.bw : nullptr;
  for (std::uint32_t i = 0; i < job.rect.bw; ++i) {
    code_block(job, coder, blocks[i],
               {i > 0 ? &blocks[i - 1] : nullptr, above != nullptr ? &above[i] : nullptr,
                i > 0 && above != nullptr ? &above[i - 1] : nullptr},
               flats_[i]);
  }
  shared = coder;
  const std::uint32_t begin = job.span.v0 + row * 8;
  const std::uint32_t rows = std::min(begin + 8, job.span.v1) - begin;
  if (job.tables.bounds->lossless()) {
    code_lossless_row(job, shared, blocks, rows);
  } else {
    drop_decisions(job, blocks, rows);
    code_decisions(shared);
  }
  jumps_in_ = jumps_out_ = 0;
}

}  // namespace planecast
