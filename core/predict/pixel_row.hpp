// What later pixels need of the rows above and of the pixel before: decoded levels and how well
// they were predicted, as arrays, so that neighbours are read at one stroke.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "core/model/lanes.hpp"

namespace planecast {

/// Most pixels along a row of a tile.
inline constexpr std::uint32_t kMaxTileSide = 2048;

/// A pixel's prediction misses less than this, or as good as this.
inline constexpr int kMissCap = 100;

/// One row of a tile; pixel x lies at index x + kBorder, and what lies outside reads as a hole.
struct PixelRow {
  static constexpr std::uint32_t kBorder = 4;
  static constexpr std::size_t kSize = kMaxTileSide + 2 * kBorder;

  std::uint16_t level[kSize] = {};   ///< 0: no reading
  std::uint8_t size[kSize] = {};     ///< magnitude of its correction: 0, 1, 2 for more
  std::int8_t lean[kSize] = {};      ///< sign of its correction: -1, 0, 1
  std::uint8_t choice[kSize] = {};   ///< surfaces kind: 0 off, 1 on the first surface, 2 the second
  std::uint32_t misses[kSize] = {};  ///< |level - surface prediction| << 16 | |... neighbours'|

  /// Makes pixels x0 .. x1-1 holes.
  void clear(std::uint32_t x0, std::uint32_t x1) noexcept {
    const std::size_t at = x0 + kBorder, count = x1 - x0;
    std::memset(level + at, 0, count * sizeof *level);
    std::memset(size + at, 0, count);
    std::memset(lean + at, 0, count);
    std::memset(choice + at, 0, count);
    std::memset(misses + at, 0, count * sizeof *misses);
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
    return 2 * (here.misses[at - 1] + above.misses[at]) + above.misses[at - 1] +
           above.misses[at + 1];
  }
  /// Correction sizes of l, u, ul, ur as digits of base three.
  std::uint32_t sizes() const noexcept {
    return here.size[at - 1] * 27U + above.size[at] * 9U + above.size[at - 1] * 3U +
           above.size[at + 1];
  }
};

}  // namespace planecast
