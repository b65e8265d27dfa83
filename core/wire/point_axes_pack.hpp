// Chooses the cells of a frame of points: cubes under the bound, or, on axes whose coordinates lie
// on a lattice coarser than those, the lattice itself. Encoder half.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "core/base/arena.hpp"
#include "core/base/status.hpp"
#include "core/wire/point_cells.hpp"

namespace planecast {

/// The cells of a frame; its slices take the pitches, each with a base of its own.
struct FrameCells {
  CellAxes axes;
  std::array<bool, 3> own_pitch{};       ///< not that of the tolerance's cube
  std::array<std::uint32_t, 3> reach{};  ///< largest distance of a point from its middle, each axis

  /// The cell that coordinate `value` belongs to on axis `i`: that of the nearest middle.
  std::uint32_t cell(std::size_t i, std::int32_t value) const noexcept {
    const std::uint64_t up = (static_cast<std::uint32_t>(value) ^ 0x80000000U) - axes[i].base;
    return static_cast<std::uint32_t>(((up << 16U) + axes[i].pitch / 2) / axes[i].pitch);
  }
};

/// Finds the cells of one frame after another. One thread; memory from the arena at start.
class CellChooser {
 public:
  void layout(Arena& arena) noexcept;

  /// Cells that keep every one of `points` (any number) within the tolerance. O(n).
  FrameCells choose(const PointCoding& coding, std::span<const GridPoint> points) noexcept;

 private:
  bool find_lattice(std::span<const GridPoint> points, std::size_t axis, std::uint32_t least_pitch,
                    std::uint32_t most_off, CellAxis& found) noexcept;

  std::span<std::uint32_t> sample_;
};

}  // namespace planecast
