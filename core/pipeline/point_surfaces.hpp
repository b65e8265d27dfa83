// From a list of points to the surfaces they lie on, as three steps that stages call: the paper's
// chain, or the fast one over voxels. Both end in drafts of patches and in what became of each
// point.
#pragma once

#include <cstdint>
#include <span>

#include "core/base/arena.hpp"
#include "core/base/status.hpp"
#include "core/filter/statistical_outliers.hpp"
#include "core/fit/point_planes.hpp"
#include "core/hull/occupancy_hull.hpp"
#include "core/search/point_neighbours.hpp"
#include "core/segment/point_normals.hpp"
#include "core/segment/point_region_growing.hpp"
#include "core/segment/voxel_regions.hpp"

namespace planecast {

/// How regions of unorganised clouds are found.
enum class PointMethod : std::uint8_t {
  kVoxels = 0,  ///< running sums of voxels: under 1 us a point
  kPaper = 1,   ///< Imdad et al. 2019: normals and curvature of each point's k nearest
};

struct PointSurfaceOptions {
  PointMethod method = PointMethod::kVoxels;
  std::uint32_t neighbours = 30;    ///< k of the paper's method
  double outlier_deviations = 1.0;  ///< of the paper's outlier filter
  bool drop_outliers = true;        ///< outliers join no surface; else they are only counted
  PointRegionOptions regions;       ///< of the paper's method
  VoxelRegionOptions voxels;        ///< of the voxels'
  PointPlaneOptions planes;
  HullOptions hull;
  std::uint32_t patch_unit_nm = 78125;  ///< a step of patches
};

/// The options that suit a method when nothing else is said, for boundaries of pitch `alpha_m` (>
/// 0): the paper's own, or those that keep most points for the fast one.
PointSurfaceOptions point_surface_defaults(PointMethod method, double alpha_m) noexcept;

/// What became of a point.
enum class PointRole : std::uint8_t {
  kOffSurface = 0,  ///< on no patch
  kOnSurface = 1,   ///< counted in a patch
  kOutlier = 2,     ///< flagged by the filter (and dropped when drop_outliers)
  kUnusable = 3,    ///< a coordinate that is not finite or too far for the patches' steps
};

/// Finds the surfaces of one frame at a time. One thread; memory from the arena at start: about 230
/// bytes a point for kVoxels, 110 + 4 k for kPaper.
class PointSurfaces {
 public:
  void layout(Arena& arena, std::uint32_t max_points, const PointSurfaceOptions& options) noexcept;

  /// The steps, in this order; `points` [m] and `options` the same in all three, options.method,
  /// neighbours, min_points and hull as in the layout. kFrameTooLarge; kBadConfig: an option out of
  /// its range; kTooLarge never with the layout's options. No allocation.
  Status filter(std::span<const Point3f> points, const PointSurfaceOptions& options) noexcept;
  Status segment(std::span<const Point3f> points, const PointSurfaceOptions& options) noexcept;
  Status fit(std::span<const Point3f> points, const PointSurfaceOptions& options) noexcept;

  /// After filter().
  const StatisticalCut& cut() const noexcept { return cut_; }
  /// After segment().
  const PointRegionReport& regions() const noexcept { return report_; }
  /// After fit(): patches to be packed, their cells, and the role of every point as given.
  std::span<const PatchDraft> drafts() const noexcept {
    return hulls_.drafts.first(hulls_.drafts_used);
  }
  std::span<const DraftCell> cells() const noexcept {
    return hulls_.cells.first(hulls_.cells_used);
  }
  std::span<const PointRole> roles() const noexcept { return roles_.first(points_); }
  std::uint32_t on_surface() const noexcept { return on_surface_; }
  std::uint32_t planes() const noexcept { return plane_count_; }
  std::span<const PointPlane> plane_list() const noexcept { return planes_.first(plane_count_); }

 private:
  PointNeighbours search_;
  PointRegionGrowing growing_;
  VoxelRegions voxels_;
  PointPlaneFitter fitter_;
  std::span<std::uint8_t> outliers_;  ///< in search order
  PointNormals normals_;
  std::span<std::uint32_t> regions_, members_;
  std::span<PointPlane> planes_;
  std::span<PointRole> roles_;
  HullOutput hulls_;
  StatisticalCut cut_;
  PointRegionReport report_;
  std::uint32_t points_ = 0, plane_count_ = 0, on_surface_ = 0;
};

}  // namespace planecast
