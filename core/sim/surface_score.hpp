// How well found surfaces match the simulator's true ones, as range-image segmentation is scored
// (Hoover et al. 1996): a match overlaps in both directions and has the same normals.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/sensor/ray_table.hpp"
#include "core/sim/scene_view.hpp"

namespace planecast {

/// A surface as a codec finds it: inverse depth a x + b y + c + d x^2 + e x y + f y^2 over the ray
/// (x, y, 1), in any unit; d, e and f are 0 for a plane.
struct FoundSurface {
  double a = 0, b = 0, c = 0, d = 0, e = 0, f = 0;
};

struct ScoreOptions {
  double max_angle_deg = 2.0;      ///< between the normals
  double overlap = 0.8;            ///< common pixels, as a share of either one's
  std::uint32_t min_pixels = 500;  ///< smaller surfaces, true or found, are not counted
  double min_width = 0;            ///< [px] nor are true ones that are narrower, across or down
};

/// Counts of one frame, and what each found surface is. Spheres and cylinders have no plane to be
/// right about: they are not counted, nor are found surfaces that for the greater part lie on what
/// is not counted.
struct SurfaceScore {
  std::uint32_t truth = 0, found = 0;
  std::uint32_t matched = 0;  ///< pairs; each surface is in one at most
  /// For each found surface: index + 1 into the truth's surfaces (of faces in one plane, the
  /// first), 0 when it matches none.
  std::vector<std::uint16_t> truth_of;
};

/// Scores one frame. `truth_ids`: of each pixel, 0 = nothing or no reading, else index + 1 into
/// `truth` (row-major, as RoomSimulator::render gives them); faces that lie in one plane count as
/// one. `labels`: of each pixel, 0 = no surface, else index + 1 into `found`. Cold path.
SurfaceScore score_surfaces(const RayTable& rays, std::span<const std::uint16_t> truth_ids,
                            std::span<const TruthSurface> truth,
                            std::span<const std::uint8_t> labels,
                            std::span<const FoundSurface> found, const ScoreOptions& options = {});

/// Unit normal of a found surface at the ray (x, y, 1); either sign.
Vec3 found_normal(const FoundSurface& surface, double x, double y) noexcept;

}  // namespace planecast
