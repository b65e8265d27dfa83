// The body of a tile under `--effort best`, written once for both halves: `Io` codes or reads each
// decision, and its Pixels say what an encoder wants to say (docs/wire-format.md, "Mixed tile").
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstdlib>

#include "core/base/status.hpp"
#include "core/predict/blend_predictor.hpp"
#include "core/wire/mix_contexts.hpp"
#include "core/wire/mix_job.hpp"
#include "core/wire/mix_models.hpp"
#include "core/wire/tile_syntax.hpp"

namespace planecast {

/// Codes (`Side` an encoder's) or reads the rows of blocks of one tile. `Side` has bit(model,
/// want), bit_at(probability, want), raw(want, bits), which return what was coded; and, where it
/// encodes, want_block(), want_plane(), want_pixel() and, of rows of blocks, whether begins_row()
/// and keeps_row(); where it decodes, put().
template <class Side>
class MixTile {
 public:
  MixTile(MixJob& job, MixScratch& scratch, Side& side) noexcept
      : job_(job), scratch_(scratch), models_(scratch.models[0]), side_(side) {}

  /// kBadSymbol for what no encoder says.
  Status code() noexcept {
    models_ = trained_mix_models(job_.tables.bounds->lossless());
    scratch_.biases = {};
    for (BlendRow& row : scratch_.rows) row.clear(0, job_.rect.bw * 8 + BlendRow::kBorder);
    for (std::uint32_t row = 0; row < job_.rect.bh; ++row) {
      if constexpr (Side::kEncodes) {
        if (!side_.begins_row(job_, row)) break;
      }
      for (std::uint32_t i = 0; i < job_.rect.bw; ++i) {
        if (const Status status = code_block(row, i); status != Status::kOk) return status;
      }
      const std::uint32_t end = std::min(row * 8 + 8, job_.span.v1 - job_.span.v0);
      for (std::uint32_t v = row * 8; v < end; ++v) {
        if (!code_row(v)) return Status::kBadSymbol;
      }
      if constexpr (Side::kEncodes) {
        if (!side_.keeps_row(job_)) break;
      }
      if (side_.stopped()) break;
    }
    return Status::kOk;
  }

 private:
  // Eight pixels of a row.
  struct Segment {
    const BlockState& block;
    const BlockSurface* surface;
    const std::uint8_t* half_widths;
    std::uint32_t ray_class;
    std::uint32_t x0, x1, v;
    std::uint32_t right;
  };

  BlockState* blocks(std::uint32_t row) noexcept {
    return scratch_.blocks.data() + (row & 1U) * job_.rect.bw;
  }
  std::uint32_t tree(BitModel* models, int bits, std::uint32_t want) noexcept {
    std::uint32_t node = 1;
    for (int i = bits - 1; i >= 0; --i)
      node = node * 2 + (side_.bit(models[node], ((want >> i) & 1U) != 0) ? 1 : 0);
    return node - (1U << bits);
  }
  std::uint8_t label(std::uint8_t want) noexcept {
    return static_cast<std::uint8_t>(tree(models_.plain.label_index, kLabelBits, want));
  }
  // Number of `length` bits below its highest, whose next one has a model.
  std::uint32_t tail(BitModel* top, int length, std::uint32_t want) noexcept {
    std::uint32_t n = 1;
    if (length > 1) n = 2 + (side_.bit(top[length], ((want >> (length - 2)) & 1U) != 0) ? 1U : 0U);
    if (length > 2) {
      const std::uint32_t mask = (1U << (length - 2)) - 1;
      n = (n << (length - 2)) + side_.raw(want & mask, length - 2);
    }
    return n;
  }
  std::int32_t plane_steps(int kind, int context, std::int32_t want) noexcept {
    BitModel* unary = models_.plain.plane_length[kind][context];
    const auto size = static_cast<std::uint32_t>(std::abs(want));
    const int wanted = static_cast<int>(std::bit_width(size));
    int length = 0;
    while (length < kPlaneLengths - 1 && side_.bit(unary[length], wanted > length)) ++length;
    if (length == 0) return 0;
    const bool negative = side_.bit(models_.plain.plane_sign[kind], want < 0);
    const auto n = static_cast<std::int32_t>(tail(models_.plain.plane_top[kind], length, size));
    return negative ? -n : n;
  }

  Status code_block(std::uint32_t row, std::uint32_t i) noexcept {
    BlockState* here = blocks(row);
    const BlockState* above = row > 0 ? blocks(row + 1) : nullptr;
    const BlockNeighbours n{i > 0 ? &here[i - 1] : nullptr, above != nullptr ? &above[i] : nullptr,
                            i > 0 && above != nullptr ? &above[i - 1] : nullptr};
    BlockState want;
    if constexpr (Side::kEncodes) want = side_.want_block(job_, row, i);
    TileModels& m = models_.plain;
    BlockState& block = here[i];
    block = {};
    block.uniform = 1;
    const std::uint8_t left = n.left != nullptr ? n.left->label.first : std::uint8_t{0};
    block.any = side_.bit(m.block_any[pair_context(n.left, n.above, &BlockState::any)], want.any);
    if (block.any == 0) {
      block.label = n.left != nullptr ? n.left->label : BlockLabel{};
      return Status::kOk;
    }
    block.full =
        side_.bit(m.block_full[pair_context(n.left, n.above, &BlockState::full)], want.full);
    if (job_.surface_count > 0) code_label(n, left, want, block);
    if (block.label.first > job_.surface_count || block.label.second > job_.surface_count)
      return Status::kBadSymbol;
    if (block.label.first != 0) {
      scratch_.surfaces[i] =
          block_surface(job_.surfaces[block.label.first], *job_.tables.rays, *job_.tables.levels,
                        job_.rect.bx + i, job_.rect.by + row);
    }
    if (may_be_flat(job_.tables, block)) code_flat(row, i, n);
    return Status::kOk;
  }

  void code_label(const BlockNeighbours& n, std::uint8_t left, const BlockState& want,
                  BlockState& block) noexcept {
    TileModels& m = models_.plain;
    const int context = label_context(n);
    const std::uint8_t above = n.above != nullptr ? n.above->label.first : std::uint8_t{0};
    block.label.first = left;
    if (!side_.bit(m.label_as_left[context], want.label.first == left)) {
      block.label.first = above;
      if (above == left || !side_.bit(m.label_as_above[context], want.label.first == above))
        block.label.first = label(want.label.first);
    }
    if (!job_.surfaces_kind || block.label.first == 0) return;
    if (side_.bit(m.block_second[0], want.label.second != 0))
      block.label.second = label(want.label.second);
    block.uniform = side_.bit(m.block_uniform[block.label.second != 0 ? 1 : 0], want.uniform != 0);
  }

  void code_flat(std::uint32_t row, std::uint32_t i, const BlockNeighbours& n) noexcept {
    BlockState* here = blocks(row);
    BlockPlane* planes = scratch_.planes.data() + (row & 1U) * job_.rect.bw;
    const PlaneHints hints = plane_hints(row, i);
    const BoundTable& bounds = *job_.tables.bounds;
    const std::uint8_t ray_class = bounds.ray_class(job_.rect.bx + i, job_.rect.by + row);
    const std::uint8_t* half_widths = bounds.half_widths(ray_class);
    const BlockPlane foretold = foretell_plane(hints, half_widths, job_.last_level);
    const PlaneSteps steps(half_widths[(foretold.middle + 128) >> 8]);
    PlaneCode want;
    bool fits = false;
    if constexpr (Side::kEncodes)
      fits = side_.want_plane(job_, row, i, ray_class, foretold, steps, want);
    here[i].flat = side_.bit(models_.plain.block_flat[flat_context(n, here[i])], fits);
    if (here[i].flat == 0) return;
    const PlaneContexts contexts(hints);
    PlaneCode got;
    got.offset = plane_steps(0, contexts.offset, want.offset);
    got.dx = plane_steps(1, contexts.dx(got.offset), want.dx);
    got.dy = plane_steps(2, contexts.dy(got.dx), want.dy);
    planes[i] = BlockPlane::clamped(foretold.middle + got.offset * steps.offset,
                                    foretold.dx + got.dx * steps.slope,
                                    foretold.dy + got.dy * steps.slope, job_.last_level);
    job_.last_middle = planes[i].middle;
    scratch_.surfaces[i] = planes[i].surface();
  }

  PlaneHints plane_hints(std::uint32_t row, std::uint32_t i) noexcept {
    const std::uint32_t bw = job_.rect.bw;
    const BlockState* here = blocks(row);
    const BlockPlane* planes = scratch_.planes.data() + (row & 1U) * bw;
    PlaneHints h;
    if (i > 0 && here[i - 1].flat != 0) h.left = &planes[i - 1];
    if (row > 0) {
      const BlockState* above = blocks(row + 1);
      const BlockPlane* planes_above = scratch_.planes.data() + ((row + 1) & 1U) * bw;
      if (above[i].flat != 0) h.above = &planes_above[i];
      if (i > 0 && above[i - 1].flat != 0) h.above_left = &planes_above[i - 1];
      if (i + 1 < bw && above[i + 1].flat != 0) h.above_right = &planes_above[i + 1];
    }
    h.surface = here[i].label.first != 0 ? &scratch_.surfaces[i] : nullptr;
    h.row_above = levels_above(row, i);
    h.fallback = job_.last_middle;
    return h;
  }

  std::int32_t levels_above(std::uint32_t row, std::uint32_t i) const noexcept {
    const BlendRow& above = scratch_.rows[(row * 8 + 2) % 3];
    std::int32_t sum = 0;
    for (std::uint32_t x = 0; x < 8; ++x) {
      const std::uint16_t level = above.level[BlendRow::kBorder + std::size_t{i} * 8 + x];
      if (level == 0) return 0;
      sum += level;
    }
    return sum * 32;
  }

  bool code_row(std::uint32_t v) noexcept {
    const BlockState* here = blocks(v / 8);
    for (std::uint32_t i = 0; i < job_.rect.bw; ++i) {
      const std::uint32_t x0 = i * 8, x1 = std::min(x0 + 8, job_.columns());
      const BlockState& block = here[i];
      if (block.any == 0) {
        scratch_.rows[v % 3].clear(x0, x1);
        if constexpr (!Side::kEncodes) side_.put_holes(x0, x1, v);
        continue;
      }
      const BoundTable& bounds = *job_.tables.bounds;
      const std::uint8_t ray_class = bounds.ray_class(job_.rect.bx + i, job_.rect.by + v / 8);
      std::uint32_t right = 2;
      if (i + 1 < job_.rect.bw) right = here[i + 1].any == 0 ? 0 : (here[i + 1].full != 0 ? 3 : 1);
      const Segment segment{
          block, &scratch_.surfaces[i], bounds.half_widths(ray_class), ray_class, x0, x1, v, right};
      for (std::uint32_t x = x0; x < x1; ++x) {
        if (!code_pixel(segment, x)) return false;
      }
    }
    return true;
  }

  bool code_pixel(const Segment& s, std::uint32_t x) noexcept {
    BlendRow& here = scratch_.rows[s.v % 3];
    const BlendAround n{here, scratch_.rows[(s.v + 2) % 3], scratch_.rows[(s.v + 1) % 3],
                        x + BlendRow::kBorder};
    std::uint16_t want = 0;
    if constexpr (Side::kEncodes) want = side_.want_depth(job_, x, s.v);
    if (s.block.full == 0 && !code_mask(n, x, s.right, want != 0)) {
      here.set(n.at, 0);
      if constexpr (!Side::kEncodes) side_.put_holes(x, x + 1, s.v);
      return true;
    }
    ++job_.points;
    std::uint8_t label = job_.surfaces_kind ? std::uint8_t{0} : s.block.label.first;
    std::uint16_t depth = 0;
    if (s.block.flat != 0) {
      const std::int32_t level =
          std::clamp((s.surface->at(x - s.x0, s.v % 8) + 128) >> 8, 1, job_.last_level);
      here.set(n.at, static_cast<std::uint16_t>(level));
      job_.fallback = level;
    } else if (const std::uint8_t choice = code_choice(s, n, x, want); choice != 0) {
      label = choice == 1 ? s.block.label.first : s.block.label.second;
      depth = on_surface(label, x, s.v);
      if (depth == 0) return false;
      job_.fallback = std::max<std::int32_t>(1, job_.tables.levels->nearest(depth));
      here.set(n.at, job_.tables.levels->nearest(depth), choice);
    } else if (!code_level(s, n, x, want, depth)) {
      return false;
    }
    if constexpr (!Side::kEncodes) {
      const auto level = static_cast<std::uint32_t>(here.level[n.at]);
      side_.put(x, s.v, depth != 0 ? depth : job_.tables.levels->depth(level), label);
    }
    return true;
  }

  std::uint16_t on_surface(std::uint8_t label, std::uint32_t x, std::uint32_t v) const noexcept {
    const std::uint32_t u = job_.span.u0 + x;
    return surface_depth(job_.surfaces[label], job_.tables.rays->x(u, job_.span.v0 + v),
                         job_.tables.rays->y(u, job_.span.v0 + v));
  }

  // Which surface of its block a pixel is on, 0 none (surfaces kind).
  std::uint8_t code_choice(const Segment& s, const BlendAround& n, std::uint32_t x,
                           std::uint16_t want) noexcept {
    if (!job_.surfaces_kind || s.block.label.first == 0) return 0;
    std::uint8_t wanted = 0;
    if constexpr (Side::kEncodes)
      wanted = side_.want_choice(job_, s.block, s.ray_class, x, s.v, want);
    if (s.block.uniform != 0) return 1;
    const int context =
        (n.here.choice[n.at - 1] * 3 + n.above.choice[n.at]) * 3 + n.above.choice[n.at - 1];
    if (side_.bit(models_.plain.on_surface[0][context], wanted == 1)) return 1;
    if (s.block.label.second == 0) return 0;
    return side_.bit(models_.plain.on_surface[1][context], wanted == 2) ? 2 : 0;
  }

  bool code_mask(const BlendAround& n, std::uint32_t x, std::uint32_t right, bool want) noexcept {
    const MaskContexts c = mask_contexts(n, x, static_cast<int>(right));
    MixedModel* models[kMaskInputs];
    for (std::size_t i = 0; i < kMaskInputs; ++i) models[i] = &models_.mask[c.of[i]];
    MixWeights<kMaskInputs>& mixer = models_.mask_mixers[c.mixer];
    const MixedDecision<kMaskInputs> mixed(mixer, models);
    const bool got = side_.bit_at(mixed.probability, want);
    mixed.learn(mixer, models, got);
    return got;
  }

  bool decide(const PixelContexts& c, int slot, bool want) noexcept {
    MixedModel* models[kPixelInputs];
    for (std::size_t i = 0; i < kPixelInputs; ++i) models[i] = &models_.pixel[c.of[i]][slot];
    MixWeights<kPixelInputs>& mixer = models_.pixel_mixers[slot][c.mixer];
    const MixedDecision<kPixelInputs> mixed(mixer, models);
    const bool got = side_.bit_at(mixed.probability, want);
    mixed.learn(mixer, models, got);
    return got;
  }

  // The block's surface at a pixel, drawn to the readings around it; 0 where there is none.
  std::int32_t drawn_surface(const Segment& s, const BlendAround& n, std::uint32_t x) noexcept {
    if (s.block.label.first == 0) return 0;
    const BlockSurface& surface = *s.surface;
    const std::int32_t at = surface.at(x - s.x0, s.v % 8);
    const std::int32_t reach =
        s.half_widths[std::clamp((surface.at(4, 4) + 128) >> 8, 1, job_.last_level)];
    const std::int32_t limit = (12 + 3 * reach) * 256;
    std::int32_t sum = 0, weight = 0;
    const auto draw = [&](std::uint16_t level, std::int32_t expected, std::int32_t w) {
      const std::int32_t off = level * 256 - expected;
      if (level == 0 || off > limit || off < -limit) return;
      sum += w * off;
      weight += w;
    };
    draw(n.here.level[n.at - 1], at - surface.dx, 4);
    draw(n.above.level[n.at], at - surface.dy, 4);
    draw(n.above.level[n.at - 1], at - surface.dx - surface.dy, 1);
    draw(n.above.level[n.at + 1], at + surface.dx - surface.dy, 2);
    const std::int32_t drift = static_cast<std::int32_t>(
        (std::int64_t{sum} * detail::kDriftScale[static_cast<std::size_t>(weight)]) >> 16);
    return std::clamp(at + drift, 256, 256 * job_.last_level);
  }

  bool code_level(const Segment& s, const BlendAround& n, std::uint32_t x, std::uint16_t want,
                  std::uint16_t& depth) noexcept {
    BlendRow& here = scratch_.rows[s.v % 3];
    const BlendLevels around(n, job_.fallback);
    const BlendedPixel p = blend_pixel(n, around, drawn_surface(s, n, x), scratch_.biases,
                                       s.half_widths, job_.last_level);
    const PixelContexts c = pixel_contexts(n, around, p, s.block.label.first != 0);
    std::int32_t wanted = 0;
    MixJump jump;
    if constexpr (Side::kEncodes) wanted = side_.want_correction(job_, p, s.ray_class, want, jump);
    std::int32_t level = p.level, correction = 0;
    if (decide(c, 0, wanted != 0)) {
      const bool up = decide(c, 1, (wanted > 0) != c.mirrored) != c.mirrored;
      const std::int32_t size = code_size(c, std::abs(wanted));
      correction = up ? size : -size;
      level = p.level + correction * p.step();
      if (size > kMaxUnary) level = code_jump(p, up, jump, depth);
      ++job_.corrections;
    }
    if (level < 1 || level > job_.last_level) return false;
    keep_blended(here, n.at, p, scratch_.biases, level, correction);
    job_.fallback = level;
    return true;
  }

  // Sizes 1, 2, 3, 4, 5-6, 7-8, 9-12, more.
  std::int32_t code_size(const PixelContexts& c, std::int32_t want) noexcept {
    static constexpr std::int32_t kLeast[] = {1, 2, 3, 4, 5, 7, 9, 13};
    int group = 0;
    while (group < 7 && decide(c, 2 + group, want >= kLeast[group + 1])) ++group;
    if (group < 4) return group + 1;
    if (group == 7) return kMaxUnary + 1;
    const int bits = group == 6 ? 2 : 1;
    return kLeast[group] +
           static_cast<std::int32_t>(tree(models_.low[group - 4], bits,
                                          static_cast<std::uint32_t>(want - kLeast[group])));
  }

  // A level far away, or a count off the levels; 0 for what no encoder says.
  std::int32_t code_jump(const BlendedPixel& p, bool up, const MixJump& want,
                         std::uint16_t& depth) noexcept {
    const auto distance = static_cast<std::uint32_t>(want.levels);
    const auto length =
        static_cast<int>(tree(models_.plain.jump_length, kJumpBits,
                              static_cast<std::uint32_t>(std::bit_width(distance))));
    if (length == 0) {
      depth = static_cast<std::uint16_t>(side_.raw(want.depth, 16));
      return job_.tables.levels->nearest(depth);
    }
    if (length > 16) return 0;
    const auto got = static_cast<std::int32_t>(tail(models_.plain.jump_top, length, distance));
    return p.level + (up ? got : -got);
  }

  MixJob& job_;
  MixScratch& scratch_;
  MixModels& models_;
  Side& side_;
};

}  // namespace planecast
