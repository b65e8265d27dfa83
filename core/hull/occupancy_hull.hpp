// The boundary of a plane's points: the cells of a grid of pitch alpha that hold one, in the two
// coordinates that are left when that of least variance is dropped; small gaps closed. Holes and
// islands are as they come (docs/decisions.md, "The hull of a plane's points").
#pragma once

#include <cstdint>
#include <span>

#include "core/base/status.hpp"
#include "core/model/patch_draft.hpp"

namespace planecast {

struct HullOptions {
  double points_per_cell = 4.0;      ///< the pitch is doubled until occupied cells hold as many
  std::uint32_t closing_rounds = 2;  ///< rounds in which cells amid occupied ones are taken in
};

/// Cells that the hulls of planes of `points` points in all can never exceed.
std::size_t hull_cells(std::uint32_t points, std::uint32_t planes) noexcept;

/// Makes `draft` of a plane and its members (places in `points`); its cells are appended to `cells`
/// behind `used`, which grows. Every member lies in a cell that is inside. The pitch is alpha
/// (2^kAlphaPitchLog2 steps of `unit_m`) or, where points lie too far apart for that, alpha times a
/// power of two. kFieldRange: no members, or one beyond the format's coordinates; kTooLarge:
/// `cells` is full. O(members + cells), no allocation.
Status make_hull(const PointPlane& plane, std::span<const std::uint32_t> members,
                 const PointColumns& points, double unit_m, const HullOptions& options,
                 std::span<DraftCell> cells, std::size_t& used, PatchDraft& draft) noexcept;

}  // namespace planecast
