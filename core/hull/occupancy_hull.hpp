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
  double points_per_cell = 1.5;      ///< the pitch is doubled until occupied cells hold as many
  std::uint32_t closing_rounds = 1;  ///< rounds in which cells amid occupied ones are taken in
  std::uint32_t least_points = 16;   ///< of a part of a plane that lies far apart; 2 or more
};

/// Cells and drafts that the hulls of planes of `points` points in all can never exceed.
std::size_t hull_cells(std::uint32_t points, std::uint32_t planes,
                       const HullOptions& options) noexcept;
std::size_t hull_drafts(std::uint32_t points, std::uint32_t planes,
                        const HullOptions& options) noexcept;

/// Where make_hulls() puts what it makes: memory of the caller's, and how much of it is in use.
struct HullOutput {
  std::span<DraftCell> cells;
  std::span<PatchDraft> drafts;
  std::size_t cells_used = 0;
  std::uint32_t drafts_used = 0;
};

/// Makes drafts of a plane and its `members` (places in `points`), appended to `output`. A plane
/// whose points fill little of their rectangle (a strip across it, islands far apart) is cut into
/// parts, a draft each. Points of parts with fewer than least_points (all points where the plane
/// itself has fewer count) and of cells that touch no other are left out: `members` is reordered so
/// that the `kept` ones stand first. Every one of these lies in a cell that is inside. The pitch is
/// alpha (2^kAlphaPitchLog2 steps of `unit_m`) or, where points lie too far apart for that, alpha
/// times a power of two. kFieldRange: a member beyond the format's coordinates; kTooLarge: output
/// is full; kBadConfig: options. O(members log members + cells), no allocation.
Status make_hulls(const PointPlane& plane, std::span<std::uint32_t> members,
                  const PointColumns& points, double unit_m, const HullOptions& options,
                  HullOutput& output, std::uint32_t& kept) noexcept;

}  // namespace planecast
