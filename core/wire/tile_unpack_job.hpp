// What the two halves of TileUnpacker share: tiles under a bound (tile_unpack.cpp) and the rows of
// lossless ones (tile_unpack_lossless.cpp). Decoder half, seen by these two files only.
#pragma once

#include <cstdint>

#include "core/wire/tile_unpack.hpp"

namespace planecast {

// One call of unpack(): the tile's place and what is derived from it.
struct TileUnpacker::Job {
  const CodingTables& tables;
  const TileTarget& target;
  TileContent& content;
  TileSpan span;
  bool surfaces_kind = false;
  bool lossless = false;
  bool every_count = false;  ///< no lattice of levels
  std::int32_t last_level = 1;
  std::int32_t fallback = 1;
  std::int32_t last_middle = 256;  ///< of the flat block coded last
  Surface surfaces[kMaxSurfaces + 1] = {};

  const TileRect& rect() const noexcept { return content.rect; }
  std::uint32_t width() const noexcept { return tables.config->camera.width; }
};

// Eight pixels of one row, within one block.
struct TileUnpacker::Segment {
  const BlockState& block;
  const BlockSurface* surface;      ///< that the block lies on, or its plane when flat; else null
  const std::uint8_t* half_widths;  ///< of the block's ray class
  std::uint32_t x0, x1;             ///< columns within the tile
  std::uint32_t v;                  ///< row of the image
  std::uint16_t* depth;             ///< of the tile's row
  std::uint8_t* labels;             ///< of the tile's row, or null
};

[[gnu::always_inline]] inline bool TileUnpacker::read_mask(RangeDecoder& coder,
                                                           MaskWalk& mask) noexcept {
  const bool reading = coder.bit(models_.mask[mask.context()]);
  mask.step(reading);
  return reading;
}

}  // namespace planecast
