// What the two halves of a mixed tile share beside its syntax: working memory, the tile being
// coded, and what an encoder wants to say (docs/wire-format.md, "Mixed tiles").
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include "core/base/arena.hpp"
#include "core/predict/blend_predictor.hpp"
#include "core/wire/mix_models.hpp"
#include "core/wire/tile_syntax.hpp"

namespace planecast {

/// Working memory of one coder or decoder of mixed tiles.
struct MixScratch {
  std::span<BlendRow> rows;          ///< three
  std::span<BlockState> blocks;      ///< two block rows
  std::span<BlockPlane> planes;      ///< beside blocks
  std::span<BlockSurface> surfaces;  ///< of a block row
  std::span<MixModels> models;       ///< one
  BlendBiases biases{};

  void layout(Arena& arena, std::uint32_t max_width) noexcept {
    const std::uint32_t wide = std::min<std::uint32_t>((max_width + 7) / 8, kMaxTileBlocks);
    rows = arena.take<BlendRow>(3);
    blocks = arena.take<BlockState>(2 * std::size_t{wide});
    planes = arena.take<BlockPlane>(2 * std::size_t{wide});
    surfaces = arena.take<BlockSurface>(wide);
    models = arena.take<MixModels>(1);
  }
};

/// A tile being coded: its place, its surfaces, and what it came to.
struct MixJob {
  const CodingTables& tables;
  TileRect rect;
  TileSpan span;
  bool surfaces_kind = false;
  std::int32_t last_level = 1;
  std::int32_t fallback = 1;       ///< level of the pixel coded last
  std::int32_t last_middle = 256;  ///< of the flat block coded last
  int surface_count = 0;
  Surface surfaces[kMaxSurfaces + 1] = {};
  std::uint32_t points = 0, corrections = 0;

  MixJob(const CodingTables& t, const TileRect& r) noexcept
      : tables(t),
        rect(r),
        span(tile_span(t.config->camera, r)),
        surfaces_kind(t.config->tolerance == ToleranceKind::kSurfaces),
        last_level(static_cast<std::int32_t>(t.levels->count()) - 1) {}
  std::uint32_t columns() const noexcept { return span.u1 - span.u0; }
  void begin_at(std::uint16_t first) noexcept {
    fallback = std::max<std::int32_t>(1, tables.levels->nearest(first));
    last_middle = fallback * 256;
  }
};

/// Steps of a flat block's plane from the one foretold.
struct PlaneCode {
  std::int32_t offset = 0, dx = 0, dy = 0;
};

/// A far correction, or a reading off the levels.
struct MixJump {
  std::int32_t levels = 0;  ///< 0: the count itself follows
  std::uint16_t depth = 0;
};

}  // namespace planecast
