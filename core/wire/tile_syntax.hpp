// The parts of a tile's syntax that both halves read from one place: its rectangle, the decisions
// of a block, and their contexts (docs/wire-format.md, "Tile").
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "core/model/frame_model.hpp"
#include "core/model/stream_config.hpp"
#include "core/predict/bound_table.hpp"
#include "core/predict/level_table.hpp"
#include "core/predict/pixel_predictor.hpp"
#include "core/sensor/ray_table.hpp"
#include "core/wire/tile_models.hpp"

namespace planecast {

/// Everything derived from a key packet that coding a tile reads. Not owned.
struct CodingTables {
  const StreamConfig* config = nullptr;
  const RayTable* rays = nullptr;
  const LevelTable* levels = nullptr;
  const BoundTable* bounds = nullptr;
};

/// Most blocks along one side of a tile.
inline constexpr std::uint32_t kMaxTileBlocks = 256;

/// A rectangle of blocks.
struct TileRect {
  std::uint32_t bx = 0, by = 0;  ///< first block
  std::uint32_t bw = 0, bh = 0;  ///< size, 1 .. kMaxTileBlocks
};

inline std::uint32_t blocks_wide(const CameraModel& c) noexcept {
  return (c.width + 7U) / 8U;
}
inline std::uint32_t blocks_high(const CameraModel& c) noexcept {
  return (c.height + 7U) / 8U;
}

/// Bits that tell a block position apart: enough for 0 .. blocks-1.
inline int position_bits(std::uint32_t blocks) noexcept {
  return std::max(1, static_cast<int>(std::bit_width(blocks - 1)));
}

/// What the header decisions say of one block; the state that contexts of later blocks read.
struct BlockState {
  std::uint8_t any = 0;
  std::uint8_t full = 0;
  std::uint8_t corrected = 0;
  std::uint8_t uniform = 0;
  BlockLabel label;
};

/// Number of the pair (left, above), each 0, 1 or, outside the tile, 2.
inline int pair_context(const BlockState* left, const BlockState* above,
                        std::uint8_t BlockState::*what) noexcept {
  const int l = left != nullptr ? (left->*what) : 2;
  const int a = above != nullptr ? (above->*what) : 2;
  return l * 3 + a;
}

/// The coded blocks around one; null outside the tile.
struct BlockNeighbours {
  const BlockState* left = nullptr;
  const BlockState* above = nullptr;
  const BlockState* above_left = nullptr;
};

inline int label_context(const BlockNeighbours& n) noexcept {
  const int l = n.left != nullptr ? n.left->label.first : 0;
  const int a = n.above != nullptr ? n.above->label.first : 0;
  const int al = n.above_left != nullptr ? n.above_left->label.first : 0;
  return (l == a ? 1 : 0) + (a == al ? 2 : 0);
}

/// Context of a pixel's "is there a reading", from eight causal neighbours.
inline int mask_context(const Neighbourhood& n, bool urr, bool uul) noexcept {
  return (n.l.level != 0) | (n.u.level != 0) << 1 | (n.ul.level != 0) << 2 |
         (n.ur.level != 0) << 3 | (n.ll != 0) << 4 | (n.uu != 0) << 5 | int{urr} << 6 |
         int{uul} << 7;
}

/// The pixels of a tile: columns u0 .. u1-1, rows v0 .. v1-1 of the image.
struct TileSpan {
  std::uint32_t u0 = 0, v0 = 0, u1 = 0, v1 = 0;
};

inline TileSpan tile_span(const CameraModel& camera, const TileRect& rect) noexcept {
  return {rect.bx * 8, rect.by * 8, std::min<std::uint32_t>((rect.bx + rect.bw) * 8, camera.width),
          std::min<std::uint32_t>((rect.by + rect.bh) * 8, camera.height)};
}

/// Pixel states a tile of `bw` blocks needs: three rows, each with a border of two on both sides,
/// so that neighbours outside the tile read as "no reading".
inline constexpr std::uint32_t kRowBorder = 2;
inline std::size_t row_states(std::uint32_t bw) noexcept {
  return std::size_t{bw} * 8 + 2 * kRowBorder;
}

/// Walks one row of a tile, keeping the neighbourhood of the current pixel.
class RowCursor {
 public:
  /// `rows`: 3 * row_states(bw) states, all empty before a tile's first row; tile_v counts rows.
  RowCursor(PixelState* rows, std::uint32_t bw, std::uint32_t tile_v) noexcept
      : current_(rows + (tile_v % 3) * row_states(bw) + kRowBorder),
        above_(rows + ((tile_v + 2) % 3) * row_states(bw) + kRowBorder),
        above2_(rows + ((tile_v + 1) % 3) * row_states(bw) + kRowBorder) {
    around_.u = above_[0];
  }

  /// Neighbourhood of pixel x (0 first, then one more each call).
  const Neighbourhood& look(std::uint32_t x) noexcept {
    around_.ur = above_[x + 1];
    around_.uu = above2_[x].level;
    return around_;
  }

  /// Context of "is there a reading" at pixel x, after look(x).
  int mask(std::uint32_t x) const noexcept {
    return mask_context(around_, above_[x + 2].level != 0, (above_ + x - kRowBorder)->level != 0);
  }

  /// Keeps what pixel x became and moves on.
  void leave(std::uint32_t x, const PixelState& state) noexcept {
    current_[x] = state;
    around_.ll = around_.l.level;
    around_.l = state;
    around_.ul = around_.u;
    around_.u = around_.ur;
  }

 private:
  PixelState* current_;
  const PixelState* above_;
  const PixelState* above2_;
  Neighbourhood around_;
};

/// Context of which surface a pixel is on, in surfaces kind.
inline int choice_context(const Neighbourhood& n) noexcept {
  return (n.l.choice * 3 + n.u.choice) * 3 + n.ul.choice;
}

/// Decision after which a tile stores counts as they are.
inline constexpr std::uint32_t kModelled = 0;
inline constexpr std::uint32_t kVerbatim = 1;

}  // namespace planecast
