// The cells of a point stream: cubes of an odd number of grid steps whose centre is within the
// tolerance of every point in them, and their Z-order (docs/wire-format.md, "Point tile").
// Shared by both halves; integers only.
#pragma once

#include <algorithm>
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

/// Half the side of a cell [grid steps], rounded down: 3 half^2 <= tolerance^2.
constexpr std::uint32_t cell_half(const PointCoding& coding) noexcept {
  return floor_sqrt(std::uint64_t{coding.tolerance} * coding.tolerance / 3);
}

/// Number of the cell that `value` lies in, counted from the least coordinate.
constexpr std::uint32_t cell_of(std::int32_t value, std::uint32_t half) noexcept {
  const std::uint64_t up = static_cast<std::uint32_t>(value) ^ 0x80000000U;
  return static_cast<std::uint32_t>(up / (2 * std::uint64_t{half} + 1));
}

/// The middle of cell `cell`; of one that reaches past the last coordinate, that one.
constexpr std::int32_t cell_middle(std::uint32_t cell, std::uint32_t half) noexcept {
  const std::uint64_t up = std::uint64_t{cell} * (2 * std::uint64_t{half} + 1) + half;
  constexpr std::uint64_t kMost = std::numeric_limits<std::uint32_t>::max();
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(std::min(up, kMost)) ^ 0x80000000U);
}

}  // namespace planecast
