// Finds the plane that holds every reading of a block within its bound, as few steps as can be from
// the plane that the decoder foretells. Encoder half.
#pragma once

#include <cstdint>

#include "core/predict/block_plane.hpp"
#include "core/wire/tile_syntax.hpp"

namespace planecast {

/// What a block's pixels allow, in 1/256 level, row by row; a hole allows everything.
struct FlatWindow {
  alignas(16) std::int32_t low[64];
  alignas(16) std::int32_t high[64];
  alignas(16) std::int32_t own[64];  ///< the reading's own level, 0 for a hole
  std::int32_t readings = 0;
};

/// Steps from the foretold plane.
struct FlatCode {
  std::int32_t offset = 0, dx = 0, dy = 0;
};

/// Fills `window` for the block whose first reading is `depth`, of `columns` x `rows` pixels in an
/// image of `width`. Any level that rounds from within [low, high] holds the bound of its reading.
void load_window(const CodingTables& tables, const std::uint16_t* depth, std::uint32_t width,
                 std::uint32_t columns, std::uint32_t rows, std::uint8_t ray_class,
                 FlatWindow& window) noexcept;

/// True when a plane was found; `code` leads to it from `foretold`. Cost: under 1 us.
bool fit_flat(const FlatWindow& window, const BlockPlane& foretold, const PlaneSteps& steps,
              std::int32_t last_level, FlatCode& code) noexcept;

}  // namespace planecast
