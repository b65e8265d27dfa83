// Finds a plane that holds every reading of a block within its bound, few steps from the plane that
// the decoder foretells, in the middle of what the readings allow. Encoder half.
#pragma once

#include <cstdint>

#include "core/predict/block_plane.hpp"
#include "core/wire/tile_syntax.hpp"

namespace planecast {

/// The levels that a block's pixels allow, row by row.
struct FlatWindow {
  /// {0, 0} for a hole, which allows everything. After a change: prepare().
  alignas(16) std::uint16_t low[64];
  alignas(16) std::uint16_t high[64];

  /// Derives what fit_flat() reads. No bound holds a level below 1.
  void prepare() noexcept;

  /// Where all readings allow levels of one narrow range: the ends of what rounds to an allowed
  /// level, in 1/256 level from `base`, so that eight fit where two fitted.
  alignas(16) std::int16_t low_q8[64];
  alignas(16) std::int16_t high_q8[64];
  std::int32_t base = 0;  ///< level
  std::int32_t readings = 0;
  bool narrow = false;
  bool comparable = false;  ///< ... or of a range that 16 bits hold at least in levels
  bool empty = false;       ///< some reading allows no level: it lies off the levels
};

/// Steps from the foretold plane.
struct FlatCode {
  std::int32_t offset = 0, dx = 0, dy = 0;
};

/// Fills `window` for the block whose first reading is `depth`, of `columns` x `rows` pixels in an
/// image of `width`, by the levels that hold the bound of each depth count, and prepares it.
void load_window(const LevelWindow* windows, const std::uint16_t* depth, std::uint32_t width,
                 std::uint32_t columns, std::uint32_t rows, FlatWindow& window) noexcept;

/// True when a plane was found; `code` leads to it from `foretold`. Cost: some 0.1 us.
bool fit_flat(const FlatWindow& window, const BlockPlane& foretold, const PlaneSteps& steps,
              std::int32_t last_level, FlatCode& code) noexcept;

}  // namespace planecast
