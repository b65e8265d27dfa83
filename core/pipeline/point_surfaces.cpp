#include "core/pipeline/point_surfaces.hpp"

#include <algorithm>

namespace planecast {
namespace {

/// Coordinates beyond half of the patches' range are kept out of everything.
float reach_of(const PointSurfaceOptions& options) noexcept {
  return static_cast<float>(0.49 * kMaxPatchCoordinate * 1e-9 * options.patch_unit_nm);
}

std::uint32_t most_planes(std::uint32_t points, const PointSurfaceOptions& options) noexcept {
  return points / std::max(3U, options.planes.min_points) + 1;
}

}  // namespace

PointSurfaceOptions point_surface_defaults(PointMethod method, double alpha_m) noexcept {
  PointSurfaceOptions options;
  options.method = method;
  options.patch_unit_nm = patch_unit_nm(alpha_m);
  options.voxels.voxel_m = 2 * alpha_m;
  if (method == PointMethod::kVoxels) {
    options.planes.distance_m = 0.015;
    options.planes.min_points = options.voxels.min_points = 20;
  }
  return options;
}

void PointSurfaces::layout(Arena& arena, std::uint32_t max_points,
                           const PointSurfaceOptions& options) noexcept {
  const std::uint32_t n = max_points, planes = most_planes(n, options);
  if (options.method == PointMethod::kPaper) {
    search_.layout(arena, n, options.neighbours);
    growing_.layout(arena, n);
    outliers_ = arena.take<std::uint8_t>(n);
    normals_.x = arena.take<float>(n);
    normals_.y = arena.take<float>(n);
    normals_.z = arena.take<float>(n);
    normals_.curvature = arena.take<float>(n);
    regions_ = arena.take<std::uint32_t>(n);
  } else {
    voxels_.layout(arena, n);
  }
  fitter_.layout(arena, n);
  members_ = arena.take<std::uint32_t>(n);
  planes_ = arena.take<PointPlane>(planes);
  roles_ = arena.take<PointRole>(n);
  hulls_.cells = arena.take<DraftCell>(hull_cells(n, planes, options.hull));
  hulls_.drafts = arena.take<PatchDraft>(hull_drafts(n, planes, options.hull));
}

Status PointSurfaces::filter(std::span<const Point3f> points,
                             const PointSurfaceOptions& options) noexcept {
  points_ = plane_count_ = on_surface_ = hulls_.drafts_used = 0;
  hulls_.cells_used = 0;
  cut_ = {};
  report_ = {};
  if (points.size() > roles_.size()) return Status::kFrameTooLarge;
  if (options.patch_unit_nm == 0) return Status::kBadConfig;
  points_ = static_cast<std::uint32_t>(points.size());
  std::fill_n(roles_.begin(), points_, PointRole::kUnusable);
  if (options.method != PointMethod::kPaper) return Status::kOk;
  if (const Status status = search_.search(points, options.neighbours, reach_of(options));
      status != Status::kOk) {
    return status;
  }
  const std::span<std::uint8_t> flags = outliers_.first(search_.size());
  const Status status =
      flag_statistical_outliers(search_.mean_distance(), options.outlier_deviations, flags, cut_);
  if (status != Status::kOk) return status;
  const std::span<const std::uint32_t> source = search_.source();
  for (std::uint32_t i = 0; i < flags.size(); ++i)
    roles_[source[i]] = flags[i] != 0 ? PointRole::kOutlier : PointRole::kOffSurface;
  if (!options.drop_outliers) std::fill(flags.begin(), flags.end(), std::uint8_t{0});
  return Status::kOk;
}

Status PointSurfaces::segment(std::span<const Point3f> points,
                              const PointSurfaceOptions& options) noexcept {
  if (points.size() != points_) return Status::kWrongSize;
  if (options.method != PointMethod::kPaper) {
    const Status status = voxels_.find(points, reach_of(options), options.voxels, report_);
    for (const std::uint32_t i : voxels_.source()) roles_[i] = PointRole::kOffSurface;
    return status;
  }
  const std::uint32_t n = search_.size();
  const PointNormals normals{normals_.x.first(n), normals_.y.first(n), normals_.z.first(n),
                             normals_.curvature.first(n)};
  if (const Status status = estimate_normals(search_, outliers_.first(n), normals);
      status != Status::kOk) {
    return status;
  }
  return growing_.grow(search_, normals, options.regions, regions_.first(n), report_);
}

Status PointSurfaces::fit(std::span<const Point3f> points,
                          const PointSurfaceOptions& options) noexcept {
  if (points.size() != points_) return Status::kWrongSize;
  const bool paper = options.method == PointMethod::kPaper;
  const PointColumns columns = paper ? PointColumns{search_.x(), search_.y(), search_.z()}
                                     : PointColumns{voxels_.x(), voxels_.y(), voxels_.z()};
  const std::span<const std::uint32_t> source = paper ? search_.source() : voxels_.source();
  const std::span<const std::uint32_t> regions =
      paper ? std::span<const std::uint32_t>(regions_.first(search_.size())) : voxels_.regions();
  std::uint32_t members = 0;
  if (const Status status = fitter_.fit(columns, regions, report_.regions, options.planes, planes_,
                                        plane_count_, members_, members);
      status != Status::kOk) {
    return status;
  }
  for (const PointPlane& plane : planes_.first(plane_count_)) {
    std::uint32_t kept = 0;
    const std::span<std::uint32_t> own = members_.subspan(plane.first, plane.count);
    if (const Status status = make_hulls(plane, own, columns, 1e-9 * options.patch_unit_nm,
                                         options.hull, hulls_, kept);
        status != Status::kOk) {
      return status;
    }
    for (const std::uint32_t m : own.first(kept)) roles_[source[m]] = PointRole::kOnSurface;
    on_surface_ += kept;
  }
  return Status::kOk;
}

}  // namespace planecast
