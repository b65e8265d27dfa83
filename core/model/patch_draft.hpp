// A patch while the encoder still has it in real numbers: planes as fitted, and the grid of counts
// that their boundary is taken from.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "core/model/patch.hpp"

namespace planecast {

/// Coordinates in metres, one of each a point.
struct PointColumns {
  std::span<const float> x, y, z;
};

/// A plane a x + b y + c z + d = 0 of unit normal (the paper's Eq. 9) and the points it took.
struct PointPlane {
  double a = 0, b = 0, c = 1, d = 0;  ///< d in metres
  std::uint32_t region = 0;           ///< of the segmentation it was found in
  std::uint32_t first = 0;            ///< its points in the list of members, from here ...
  std::uint32_t count = 0;            ///< ... so many
};

/// A cell of a draft: how many points it holds, and whether it belongs to the patch (a cell that
/// was closed belongs to it and holds none). A cell with points is always inside.
struct DraftCell {
  std::uint32_t count_and_inside = 0;  ///< count times 2, plus inside
  bool inside() const noexcept { return (count_and_inside & 1U) != 0; }
  std::uint32_t count() const noexcept { return count_and_inside >> 1U; }
};

/// A surface with its boundary, in steps of PointStream::patch_unit_nm: cells [first_cell, + wide
/// high) of the frame's list, row by row along v.
struct PatchDraft {
  std::uint8_t degree = 1;
  std::uint8_t axis = 2;
  std::uint8_t pitch_log2 = kAlphaPitchLog2;
  std::int32_t cell_u = 0, cell_v = 0;
  std::uint32_t wide = 0, high = 0;
  std::uint32_t first_cell = 0;
  std::uint32_t points = 0;
  /// height = c0 + c1 u + c2 v + c3 uu + c4 uv + c5 vv, everything in steps, u and v absolute.
  std::array<double, kMaxPatchCoefficients> coefficients{};
};

}  // namespace planecast
