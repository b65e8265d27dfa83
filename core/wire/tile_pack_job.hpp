// What the two halves of TilePacker share: quantising (tile_pack.cpp) and coding
// (tile_pack_code.cpp). Encoder half, seen by these two files only.
#pragma once

#include <cstdint>

#include "core/wire/tile_pack.hpp"

namespace planecast {

// Tile-local numbers of the frame's surfaces that the tile uses, in order of first use.
struct LocalSurfaces {
  std::uint8_t local_of[kMaxSurfaces + 1] = {};
  std::uint8_t frame_of[kMaxSurfaces + 1] = {};
  int count = 0;

  void use(std::uint8_t label) noexcept {
    if (label == 0 || local_of[label] != 0) return;
    local_of[label] = static_cast<std::uint8_t>(++count);
    frame_of[count] = label;
  }
  /// Those of a row of blocks of a tile.
  void use_row(const FrameModel& frame, const CodingTables& tables, const TileRect& rect,
               std::uint32_t row) noexcept {
    const bool second = tables.config->tolerance == ToleranceKind::kSurfaces;
    for (const BlockLabel& label : labels(frame, tables, rect, row)) {
      use(label.first);
      if (second) use(label.second);
    }
  }
  /// Whether all those of a row of blocks have numbers.
  bool name_all(const FrameModel& frame, const CodingTables& tables, const TileRect& rect,
                std::uint32_t row) const noexcept {
    const bool second = tables.config->tolerance == ToleranceKind::kSurfaces;
    const auto named = [this](std::uint8_t label) { return label == 0 || local_of[label] != 0; };
    for (const BlockLabel& label : labels(frame, tables, rect, row)) {
      if (!named(label.first) || (second && !named(label.second))) return false;
    }
    return true;
  }

 private:
  static std::span<const BlockLabel> labels(const FrameModel& frame, const CodingTables& tables,
                                            const TileRect& rect, std::uint32_t row) noexcept {
    return frame.blocks.subspan(
        std::size_t{rect.by + row} * blocks_wide(tables.config->camera) + rect.bx, rect.bw);
  }
};

// One call of pack(): the tile's place and what is derived from it.
struct TilePacker::Job {
  const CodingTables& tables;
  const FrameModel& frame;
  TileRect rect;
  TileSpan span;
  bool surfaces_kind = false;
  std::int32_t last_level = 1;
  std::int32_t fallback = 1;       ///< level of the pixel coded last
  std::int32_t last_middle = 256;  ///< of the flat block coded last
  LocalSurfaces local = {};
  std::uint32_t points = 0, corrections = 0;

  std::uint32_t width() const noexcept { return tables.config->camera.width; }
  /// Counts of the tile in row v of the image.
  const std::uint16_t* depths(std::uint32_t v) const noexcept {
    return &frame.depth[std::size_t{v} * width() + span.u0];
  }
  const Surface& surface(std::uint8_t local_label) const noexcept {
    return frame.surfaces[local.frame_of[local_label] - 1U];
  }
};

// Eight pixels of one row, within one block.
struct TilePacker::Segment {
  BlockState& block;
  const BlockSurface* surface;  ///< that the block lies on, or null
  std::uint8_t ray_class;
  std::uint32_t x0, x1;      ///< columns within the tile
  std::uint32_t v;           ///< row of the image
  const std::uint16_t* row;  ///< counts of the tile's row

  /// Where predictions of the first pixel come from.
  PixelPlace place(const Job& job) const noexcept {
    PixelPlace out(job.tables.bounds->half_widths(ray_class), job.last_level);
    if (surface != nullptr) out.lie_on(*surface, v % 8);
    return out;
  }
};

/// Of the blocks that row v of the image goes through.
inline BlockState* TilePacker::blocks_at(const Job& job, std::uint32_t v) noexcept {
  return blocks_.data() + ((v - job.span.v0) / 8 & 1U) * job.rect.bw;
}

}  // namespace planecast
