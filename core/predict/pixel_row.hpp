// What later pixels need of the rows above and of the pixel before: decoded levels and how well
// they were predicted, as arrays, so that neighbours are read at one stroke.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "core/base/lanes.hpp"

namespace planecast {

/// Most pixels along a row of a tile.
inline constexpr std::uint32_t kMaxTileSide = 2048;

/// Misses count up to this.
inline constexpr int kMissCap = 100;

/// What is kept of a pixel beside its level. All zero for a hole.
struct PixelPast {
  std::uint32_t misses = 0;  ///< |level - surface prediction| << 16 | |level - neighbours'|
  std::uint8_t size = 0;     ///< magnitude of its correction: 0, 1, 2 for more
  std::int8_t lean = 0;      ///< sign of its correction: -1, 0, 1
  std::uint8_t choice = 0;   ///< surfaces kind: 0 off, 1 on the block's first surface, 2 the second
};

/// One row of a tile; pixel x lies at index x + kBorder, and what lies outside reads as a hole.
struct PixelRow {
  static constexpr std::uint32_t kBorder = 4;
  static constexpr std::size_t kSize = kMaxTileSide + 2 * kBorder;

  std::uint16_t level[kSize] = {};  ///< 0: no reading
  PixelPast past[kSize] = {};

  /// Makes the pixel at an index a hole.
  void set_hole(std::size_t at) noexcept {
    level[at] = 0;
    past[at] = {};
  }
  /// Makes pixels x0 .. x1-1 holes.
  void clear(std::uint32_t x0, std::uint32_t x1) noexcept {
    std::fill(level + kBorder + x0, level + kBorder + x1, std::uint16_t{0});
    forget(kBorder + x0, x1 - x0);
  }
  /// Leaves nothing of `count` pixels from an index on but their levels.
  void forget(std::size_t at, std::uint32_t count) noexcept {
    if (count == 8) {  // a size known beforehand is no call
      std::memset(static_cast<void*>(past + at), 0, 8 * sizeof(PixelPast));
    } else {
      std::fill_n(past + at, count, PixelPast{});
    }
  }
};

/// The causal neighbourhood of the pixel at index `at`: l left, u above, ul, ur; ll, uu two away.
struct Neighbourhood {
  const PixelRow& here;
  const PixelRow& above;
  const PixelRow& above2;
  std::size_t at;

  std::int32_t l() const noexcept { return here.level[at - 1]; }
  std::int32_t u() const noexcept { return above.level[at]; }
  std::int32_t ul() const noexcept { return above.level[at - 1]; }
  std::int32_t ur() const noexcept { return above.level[at + 1]; }
  std::int32_t ll() const noexcept { return here.level[at - 2]; }
  std::int32_t uu() const noexcept { return above2.level[at]; }

  /// Levels ul, u, ur and the one after.
  Int4 row_above() const noexcept {
    Count4 levels;
    std::memcpy(&levels, above.level + at - 1, sizeof levels);
    return __builtin_convertvector(levels, Int4);
  }
  /// Misses, 2 (l + u) + ul + ur, of both predictions.
  std::uint32_t misses() const noexcept {
    return 2 * (here.past[at - 1].misses + above.past[at].misses) + above.past[at - 1].misses +
           above.past[at + 1].misses;
  }
  /// Correction sizes of l, u, ul, ur as digits of base three.
  std::uint32_t sizes() const noexcept {
    return here.past[at - 1].size * 27U + above.past[at].size * 9U + above.past[at - 1].size * 3U +
           above.past[at + 1].size;
  }
};

}  // namespace planecast
