// What coding or decoding a tile came to, and where decoded pixels go.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/wire/tile_syntax.hpp"

namespace planecast {

/// What coding a tile cost and did.
struct TileReport {
  std::size_t bytes = 0;
  std::uint32_t points = 0;       ///< readings coded
  std::uint32_t corrections = 0;  ///< of them with a correction that is not zero
  bool verbatim = false;          ///< the models did not pay; counts are stored as they are
  std::uint32_t rows = 0;         ///< rows of blocks coded: all of the rectangle, or as many as fit
};

/// What one tile held.
struct TileContent {
  TileRect rect;
  std::uint32_t points = 0;                     ///< readings decoded
  std::uint32_t corrections = 0;                ///< of them with a correction that is not zero
  std::uint32_t surfaces = 0;                   ///< surfaces the tile carries
  std::array<Surface, kMaxSurfaces> surface{};  ///< the first `surfaces` are in use
  bool verbatim = false;
  bool runs = false;   ///< coded by runs, for want of time
  bool mixed = false;  ///< coded as `--effort best` does
};

/// Where a decoded tile goes: width * height of the stream's camera each, row-major. `labels` may
/// be empty; otherwise it receives 1 + the tile's surface number for pixels of labelled blocks.
struct TileTarget {
  std::span<std::uint16_t> depth;
  std::span<std::uint8_t> labels;
};

}  // namespace planecast
