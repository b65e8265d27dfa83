// The parts of a tile's syntax that both halves read from one place: its rectangle, the decisions
// of a block, and their contexts (docs/wire-format.md, "Tile").
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/model/frame_model.hpp"
#include "core/model/stream_config.hpp"
#include "core/predict/block_plane.hpp"
#include "core/predict/block_surface.hpp"
#include "core/predict/bound_table.hpp"
#include "core/predict/level_table.hpp"
#include "core/predict/pixel_predictor.hpp"
#include "core/sensor/ray_table.hpp"
#include "core/wire/mask_walk.hpp"
#include "core/wire/tile_models.hpp"

namespace planecast {

struct ResidualModels;

/// Everything derived from a key packet that coding a tile reads. Not owned.
struct CodingTables {
  const StreamConfig* config = nullptr;
  const RayTable* rays = nullptr;
  const LevelTable* levels = nullptr;
  const BoundTable* bounds = nullptr;
  const ResidualModels* residuals = nullptr;  ///< what lossless tiles start from
};

/// Most blocks along one side of a tile.
inline constexpr std::uint32_t kMaxTileBlocks = kMaxTileSide / 8;

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
  std::uint8_t flat = 0;
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

/// True when a block may be flat: under a bound, and where pixels do not choose a surface.
inline bool may_be_flat(const CodingTables& tables, const BlockState& block) noexcept {
  return !tables.bounds->lossless() &&
         (tables.config->tolerance != ToleranceKind::kSurfaces || block.label.first == 0);
}

/// The pixels of a tile: columns u0 .. u1-1, rows v0 .. v1-1 of the image.
struct TileSpan {
  std::uint32_t u0 = 0, v0 = 0, u1 = 0, v1 = 0;
};

inline TileSpan tile_span(const CameraModel& camera, const TileRect& rect) noexcept {
  return {rect.bx * 8, rect.by * 8, std::min<std::uint32_t>((rect.bx + rect.bw) * 8, camera.width),
          std::min<std::uint32_t>((rect.by + rect.bh) * 8, camera.height)};
}

/// The rows of a tile around row `tile_v`: three in turn, all holes before the first.
struct TileRows {
  PixelRow& here;
  PixelRow& above;
  PixelRow& above2;

  TileRows(std::span<PixelRow> rows, std::uint32_t tile_v) noexcept
      : here(rows[tile_v % 3]), above(rows[(tile_v + 2) % 3]), above2(rows[(tile_v + 1) % 3]) {}

  /// Contexts of the mask from pixel x on.
  MaskWalk mask(std::uint32_t x) const noexcept {
    return {here, above, above2, x + PixelRow::kBorder};
  }
  /// Neighbourhood of pixel x.
  Neighbourhood around(std::uint32_t x) const noexcept {
    return {here, above, above2, x + PixelRow::kBorder};
  }
};

/// Makes the first bw blocks of all three rows, and what lies right of them, holes.
inline void clear_rows(std::span<PixelRow> rows, std::uint32_t bw) noexcept {
  for (PixelRow& row : rows) row.clear(0, bw * 8 + PixelRow::kBorder);
}

/// Mean level, times 256, of the eight pixels above block `i` of a block row; 0 unless all are
/// there. `row` is the tile's row above that block row.
inline std::int32_t mean_above(const PixelRow& row, std::uint32_t i) noexcept {
  const std::uint16_t* level = row.level + PixelRow::kBorder + std::size_t{i} * 8;
  std::int32_t sum = 0;
  bool all = true;
  for (int x = 0; x < 8; ++x) {
    sum += level[x];
    all &= level[x] != 0;
  }
  return all ? sum * 32 : 0;
}

/// What is known of a flat block's plane before it is coded. `blocks` and `planes` of this block
/// row and of the one above (null in the tile's first).
inline PlaneHints plane_hints(const BlockState* blocks, const BlockState* above,
                              const BlockPlane* planes, const BlockPlane* planes_above,
                              std::uint32_t i, std::uint32_t bw, const BlockSurface* surface,
                              const PixelRow& row_above, std::int32_t fallback) noexcept {
  PlaneHints h;
  if (i > 0 && blocks[i - 1].flat != 0) h.left = &planes[i - 1];
  if (above != nullptr) {
    if (above[i].flat != 0) h.above = &planes_above[i];
    if (i > 0 && above[i - 1].flat != 0) h.above_left = &planes_above[i - 1];
    if (i + 1 < bw && above[i + 1].flat != 0) h.above_right = &planes_above[i + 1];
  }
  h.surface = blocks[i].label.first != 0 ? surface : nullptr;
  h.row_above = mean_above(row_above, i);
  h.fallback = fallback;
  return h;
}

/// Contexts of a plane's offset, dx and dy, each by what was coded before it.
struct PlaneContexts {
  int offset, labelled;
  explicit PlaneContexts(const PlaneHints& h) noexcept
      : offset(plane_context(h)), labelled(h.surface != nullptr ? 3 : 0) {}
  int dx(std::int32_t offset_steps) const noexcept {
    return labelled + (offset_steps != 0 ? 1 : 0);
  }
  int dy(std::int32_t dx_steps) const noexcept { return labelled + (dx_steps != 0 ? 1 : 0); }
};

/// Context of "is the block flat".
inline int flat_context(const BlockNeighbours& n, const BlockState& block) noexcept {
  return (block.label.first != 0 ? 9 : 0) + pair_context(n.left, n.above, &BlockState::flat);
}

/// keep_flat() where the block is cut by the image's border or its plane leaves the levels.
[[gnu::noinline]] inline void keep_flat_part(PixelRow& row, std::size_t at, std::int32_t q,
                                             std::int32_t dx, std::uint32_t columns,
                                             std::int32_t last_level) noexcept {
  for (std::uint32_t x = 0; x < columns; ++x, q += dx) {
    row.level[at + x] = static_cast<std::uint16_t>(std::clamp(q >> 8, 1, last_level));
  }
  row.forget(at, columns);
}

/// Levels of row y of a flat block, at the eight pixels from `at` on of `row`; nothing was missed.
inline void keep_flat(PixelRow& row, std::size_t at, const BlockSurface& plane, std::uint32_t y,
                      std::uint32_t columns, std::int32_t last_level) noexcept {
  const std::int32_t q = plane.at(0, y) + 128, end = q + 7 * plane.dx;
  const std::int32_t most = last_level * 256 + 255;
  if (columns != 8 || std::min(q, end) < 256 || std::max(q, end) > most) [[unlikely]] {
    keep_flat_part(row, at, q, plane.dx, columns, last_level);
    return;
  }
  const Int4 first = q + plane.dx * Int4{0, 1, 2, 3}, second = first + 4 * plane.dx;
  store8(row.level + at, reinterpret_cast<Count8>(low_halves8(first >> 8, second >> 8)));
  row.forget(at, 8);
}

/// Context of which surface a pixel is on, in surfaces kind.
inline std::uint8_t choice_context(const Neighbourhood& n) noexcept {
  return static_cast<std::uint8_t>((n.here.past[n.at - 1].choice * 3 + n.above.past[n.at].choice) *
                                       3 +
                                   n.above.past[n.at - 1].choice);
}

/// Decision after which a tile is not modelled.
inline constexpr std::uint32_t kModelled = 0;
inline constexpr std::uint32_t kVerbatimTile = 1;
/// Decision after which such a tile of a depth stream holds counts as they are, or runs.
inline constexpr std::uint32_t kCountsTile = 0;
inline constexpr std::uint32_t kRunTile = 1;
/// Decision after which, in streams of `--effort best`, a tile's decisions are mixed.
inline constexpr std::uint32_t kPlainTile = 0;
inline constexpr std::uint32_t kMixedTile = 1;

}  // namespace planecast
