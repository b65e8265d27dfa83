#include "core/pipeline/list_stages.hpp"

#include <algorithm>

#include "core/fit/point_rounding.hpp"
#include "core/model/point_grid.hpp"

namespace planecast {
namespace {

constexpr std::size_t kPatchHeadBytes = 64;  // numbers of a patch, whatever they are

bool finite(const Point3f& p) noexcept {
  return p.x - p.x == 0 && p.y - p.y == 0 && p.z - p.z == 0;
}

// Distance from the zero of the input's coordinates, squared.
struct Range {
  double zero[3];
  double least, most;

  Range(const StreamConfig& config, const StageOptions& options) noexcept
      : least(options.range_min_m * options.range_min_m),
        most(options.range_max_m * options.range_max_m) {
    for (std::size_t i = 0; i < 3; ++i) zero[i] = static_cast<double>(config.axes.t_um[i]) * 1e-6;
  }
  bool holds(const Point3f& p) const noexcept {
    const double x = p.x + zero[0], y = p.y + zero[1], z = p.z + zero[2];
    const double square = x * x + y * y + z * z;
    return square >= least && square <= most;
  }
};

// What the search found, as the fate of each point.
void settle_fates(const StreamConfig& config, const StageOptions& options, bool surfaces,
                  FrameSlot& slot) noexcept {
  const std::span<const PointRole> roles = slot.list_surfaces.roles();
  PointCounts& counts = slot.counts;
  for (std::uint32_t i = 0; i < slot.listed; ++i) {
    PointFate fate = PointFate::kCoded;
    if (roles[i] == PointRole::kOutlier && options.drop_outliers) {
      fate = PointFate::kOutlier;
      ++counts.outliers_dropped;
    } else if (roles[i] == PointRole::kOnSurface) {
      fate = PointFate::kOnSurface;
      ++counts.on_surface;
    } else if (surfaces) {
      ++counts.off_surface;
      if (config.drop_off_surface) {
        fate = PointFate::kOffSurface;
        ++counts.off_surface_dropped;
      }
    }
    slot.fates[i] = static_cast<std::uint8_t>(fate);
  }
}

}  // namespace

bool seeks_surfaces(const StreamConfig& config, const StageOptions& options) noexcept {
  return config.tolerance == ToleranceKind::kSurfaces && options.surfaces;
}

PointSurfaceOptions surface_options(const StreamConfig& config,
                                    const StageOptions& options) noexcept {
  // Outliers are found by neighbours, which only the paper's chain searches.
  const bool paper = options.paper || options.drop_outliers;
  const double alpha_m = patch_unit_m(config.points) * (1U << kAlphaPitchLog2);
  PointSurfaceOptions out =
      point_surface_defaults(paper ? PointMethod::kPaper : PointMethod::kVoxels, alpha_m);
  out.patch_unit_nm = config.points.patch_unit_nm;
  out.neighbours = options.neighbours;
  out.outlier_deviations = options.outlier_deviations;
  out.drop_outliers = options.drop_outliers;
  out.regions.smoothness_deg = options.smoothness_deg;
  out.planes.seed = options.seed;
  if (config.tolerance == ToleranceKind::kSurfaces)
    out.planes.distance_m = static_cast<double>(point_bound_pm(config)) * 1e-12;
  return out;
}

FrameLimits list_limits(const StreamConfig& config, const StageOptions& options,
                        const PointSurfaceOptions& search) noexcept {
  const std::uint32_t most = config.points.max_points;
  FrameLimits limits{0, 0};
  limits.max_points = most;
  limits.list_bytes = point_frame_capacity(most);
  limits.list_slices = point_slice_capacity(most, options.slice_bytes);
  const bool surfaces = seeks_surfaces(config, options);
  if (surfaces || options.drop_outliers) limits.surfaces = &search;
  if (!surfaces) return limits;
  const std::uint32_t planes = most / std::max(3U, search.planes.min_points) + 1;
  const std::size_t drafts = hull_drafts(most, planes, search.hull);
  limits.list_bytes += hull_cells(most, planes, search.hull) / 4 + kPatchHeadBytes * drafts;
  limits.list_slices = std::min<std::size_t>(65535, limits.list_slices + 2 * drafts + 64);
  return limits;
}

Status filter_list(const StreamConfig& config, const StageOptions& options,
                   FrameSlot& slot) noexcept {
  const Range range(config, options);
  std::uint32_t kept = 0, readings = 0;
  for (std::uint32_t i = 0; i < slot.listed; ++i) {
    const Point3f p = slot.points[i];
    if (!finite(p)) continue;
    ++readings;
    slot.points[kept] = p;
    kept += range.holds(p) ? 1 : 0;
  }
  slot.listed = kept;
  slot.counts.input = readings;
  slot.counts.out_of_range = readings - kept;
  std::fill_n(slot.fates.begin(), kept, static_cast<std::uint8_t>(PointFate::kCoded));
  if (!slot.seeks) return Status::kOk;
  const Status status =
      slot.list_surfaces.filter(slot.points.first(kept), surface_options(config, options));
  slot.counts.outliers = slot.list_surfaces.cut().outliers;
  return status;
}

Status segment_list(const StreamConfig& config, const StageOptions& options,
                    FrameSlot& slot) noexcept {
  if (!seeks_surfaces(config, options)) return Status::kOk;
  return slot.list_surfaces.segment(slot.points.first(slot.listed),
                                    surface_options(config, options));
}

Status fit_list(const StreamConfig& config, const StageOptions& options, FrameSlot& slot) noexcept {
  const auto points = slot.points.first(slot.listed);
  const bool surfaces = seeks_surfaces(config, options);
  if (surfaces) {
    const Status status = slot.list_surfaces.fit(points, surface_options(config, options));
    if (status != Status::kOk) return status;
    slot.surface_count = static_cast<std::uint32_t>(slot.list_surfaces.drafts().size());
  }
  if (slot.seeks) settle_fates(config, options, surfaces, slot);
  return round_points(config, points, slot.fates.first(slot.listed), slot.grid, slot.on_grid);
}

void ListPack::layout(Arena& arena, const FrameLimits& limits) noexcept {
  points_.layout(arena, limits.max_points);
  if (limits.surfaces != nullptr) patches_.layout(arena);
}

Status ListPack::process(const StreamTables& tables, const StageOptions& options,
                         const FrameIdentity& identity, FrameSlot& slot) noexcept {
  if (slot.surface_count > 0) {
    const Status status = patches_.pack(slot.list_surfaces.drafts(), slot.list_surfaces.cells(), {},
                                        options.slice_bytes, slot.packed, slot.places, slot.report);
    if (status != Status::kOk) return status;
    if (slot.on_grid == 0 && slot.report.slices > 0) {
      seal_slices(identity, slot.places.first(slot.report.slices), slot.packed);
      return Status::kOk;
    }
  }
  return points_.pack(point_coding(tables.config()), slot.grid.first(slot.on_grid), identity,
                      options.slice_bytes, slot.packed, slot.places, slot.report);
}

}  // namespace planecast
