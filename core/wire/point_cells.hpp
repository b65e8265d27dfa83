// The cells of a point stream: boxes whose middle stands for every point in them. On each axis a
// slice has its own pitch and base, so that axes on a lattice cost nothing below its pitch
// (docs/wire-format.md, "Point tile"). Shared by both halves; integers only.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "core/model/grid_point.hpp"

namespace planecast {

/// Largest integer whose square is at most `n`.
constexpr std::uint32_t floor_sqrt(std::uint64_t n) noexcept {
  std::uint64_t root = 0;
  for (std::uint64_t bit = std::uint64_t{1} << 31U; bit != 0; bit >>= 1U) {
    if ((root + bit) * (root + bit) <= n) root += bit;
  }
  return static_cast<std::uint32_t>(root);
}

/// Half the side of a cube whose middle is within the tolerance of all of it [grid steps].
constexpr std::uint32_t cell_half(const PointCoding& coding) noexcept {
  return floor_sqrt(std::uint64_t{coding.tolerance} * coding.tolerance / 3);
}

/// Pitch of cells that reach `half` grid steps to both sides of their middle [Q16].
constexpr std::uint64_t pitch_of(std::uint32_t half) noexcept {
  return (2 * std::uint64_t{half} + 1) << 16U;
}

/// Least and largest pitch of a lattice [Q16 grid steps].
inline constexpr std::uint64_t kLeastPitch = std::uint64_t{1} << 16U;
inline constexpr std::uint64_t kMostPitch = std::uint64_t{1} << 47U;

/// The cells along one axis of a slice: cell c has its middle at base + c * pitch, rounded.
struct CellAxis {
  std::uint32_t base = 0;  ///< middle of cell 0, as a coordinate plus 2^31
  std::uint64_t pitch = kLeastPitch;

  /// The last cell whose middle can lie on the grid.
  std::uint32_t last() const noexcept {
    constexpr std::uint64_t kGrid = std::uint64_t{1} << 32U;
    // A cell that begins on the grid may have its middle past the end.
    return static_cast<std::uint32_t>(std::min<std::uint64_t>(
        ((kGrid - base) << 16U) / pitch + 1, std::numeric_limits<std::uint32_t>::max()));
  }
  /// Needs cell <= last(); what lies past the last coordinate becomes that one.
  std::int32_t middle(std::uint32_t cell) const noexcept {
    const std::uint64_t up = base + ((cell * pitch + 0x8000U) >> 16U);
    constexpr std::uint64_t kMost = std::numeric_limits<std::uint32_t>::max();
    return static_cast<std::int32_t>(static_cast<std::uint32_t>(std::min(up, kMost)) ^ 0x80000000U);
  }
};

using CellAxes = std::array<CellAxis, 3>;

}  // namespace planecast
