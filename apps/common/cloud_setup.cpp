// Streams of organised clouds: as depth on a camera's rays where the points prove to lie there,
// else as raw floats. What grid and rays take of a bound is measured and taken off the codec's.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/common/cloud_counts.hpp"
#include "apps/common/points_setup.hpp"
#include "apps/common/stream_settle.hpp"
#include "core/io/cloud_builder.hpp"
#include "core/sensor/estimate_camera.hpp"
#include "core/sensor/z_grid.hpp"

namespace planecast {
namespace {

constexpr double kMostLateral = 0.25;  // of a bound: rays further off are no camera
constexpr double kMostTaken = 0.5;     // of a bound: beyond, raw floats are the better choice
constexpr double kLeastTaken = 0.005;  // of a bound: room for later frames of the same camera
constexpr double kRoom = 1.25;         // over the first frame's misfit
constexpr double kMetresSteps = 64;    // counts in a bound of metres
constexpr double kSigmaSteps = 16;     // counts in the smallest bound of sigmas

struct Extent {
  double nearest = 0, farthest = 0;  // optical depth [m]
  std::size_t readings = 0, origins = 0;
};

Extent extent_of(const PointCloud& cloud, const StreamConfig& config) {
  const OpticalAxes axes(config);
  Extent out{1e9, 0, 0, 0};
  for (const Point3f& p : cloud.points) {
    if (!is_depth_reading(p)) {
      out.origins += is_valid(p) ? 1 : 0;
      continue;
    }
    ++out.readings;
    out.nearest = std::min(out.nearest, axes.depth(p));
    out.farthest = std::max(out.farthest, axes.depth(p));
  }
  return out;
}

// Whether the list coder can keep what was asked for: a bound, and a sigma that is the same for
// all.
bool list_fits(const CodecOptions& options, const StreamSetup& setup) {
  const bool sigmas = setup.contract.kind == ToleranceKind::kSigma ||
                      setup.contract.kind == ToleranceKind::kSurfaces;
  const bool stereo = options.noise && options.noise->kind == NoiseModel::Kind::kStereo;
  return setup.contract.kind != ToleranceKind::kLossless && !(sigmas && stereo);
}

void make_raw(const CodecOptions& options, const SensorFrame& first, StreamSetup& setup,
              const std::string& why) {
  StreamConfig& config = setup.encoder.stream;
  const bool drops = config.drop_off_surface || options.outliers == Outliers::kDrop;
  config.kind = FrameKind::kRawCloud;
  config.lattice = {};
  config.axes = {};
  config.mirror_y = false;
  config.z_rule = ZRule::kProductInDouble;
  config.tolerance = ToleranceKind::kLossless;
  config.drop_off_surface = false;
  setup.contract = {};
  setup.bound_m = 0;
  setup.grid.reset();
  setup.rays.reset();
  setup.encoder.stages.range_min = 0;
  setup.encoder.stages.range_max = 65535;
  setup.raw_range = options.range;
  Intrinsics any;  // raw clouds have no rays, only a size
  any.fx = any.fy = std::max(first.cloud.width, first.cloud.height);
  any.cx = first.cloud.width / 2.0;
  any.cy = first.cloud.height / 2.0;
  (void)settle_camera(any, first.cloud.width, first.cloud.height, config);
  setup.notes.push_back(why + "; its float32 coordinates are coded losslessly" +
                        (drops ? ", and nothing is dropped" : ""));
}

Result<Done> check_cloud(const SensorFrame& first) {
  const PointCloud& cloud = first.cloud;
  if (cloud.width > kMaxImageSide || cloud.height > kMaxImageSide) {
    return Error{Status::kUnreadable,
                 fmt::format("{}: {}x{} is larger than {} a side; cut it", first.name, cloud.width,
                             cloud.height, kMaxImageSide)};
  }
  return Done{};
}

// The camera of the options, else the one the cloud itself shows; false: there is none.
Result<bool> find_camera(const CodecOptions& options, const SensorFrame& first, StreamSetup& setup,
                         Intrinsics& intrinsics, std::string& why) {
  const PointCloud& cloud = first.cloud;
  const auto given = given_camera(options, cloud.width, cloud.height, first.name, setup.notes);
  if (!given.ok()) return given.error();
  if (given->has_value()) {
    intrinsics = **given;
    return true;
  }
  const auto estimated = estimate_camera(cloud);
  if (!estimated.ok()) {
    why = first.name + ": " + estimated.error().message;
    return false;
  }
  StreamConfig& config = setup.encoder.stream;
  intrinsics = estimated->intrinsics;
  config.mirror_y = estimated->mirror_y;
  why = first.name + ": the estimated axes are out of range";
  if (to_fixed(estimated->cloud_from_optical, config.axes) != Status::kOk) return false;
  setup.notes.push_back(first.name + ": " + estimated->describe());
  return true;
}

// Metres of a count where the cloud proves no grid: fine against the bound, and the farthest
// reading still has a count.
double chosen_unit(const CodecOptions& options, const StreamSetup& setup, const Extent& extent) {
  double farthest = extent.farthest, nearest = extent.nearest;
  if (options.range) {
    farthest = std::min(farthest, options.range->max_m);
    nearest = std::max(nearest, options.range->min_m);
  }
  const bool metres = setup.contract.kind == ToleranceKind::kMetres;
  const double wanted = setup.contract.bound_m(nearest) / (metres ? kMetresSteps : kSigmaSteps);
  const double unit = std::max({farthest / 65000.0, wanted, 1e-6});
  return std::ceil(unit * 1e6) * 1e-6;
}

// Camera, grid, range, lattice and noise of a cloud with rays; false: it cannot be counted.
Result<bool> settle_grid(const CodecOptions& options, const SourceSensor& sensor,
                         const SensorFrame& first, Intrinsics intrinsics, StreamSetup& setup) {
  StreamConfig& config = setup.encoder.stream;
  const PointCloud& cloud = first.cloud;
  const bool optical = config.axes == PoseFixed{} && !config.mirror_y;
  const auto grid = optical ? find_z_grid(cloud) : std::nullopt;
  setup.grid.reset();
  if (grid) {
    intrinsics.metres_per_unit = static_cast<double>(grid->unit_pm) * 1e-12;
    config.z_rule = static_cast<ZRule>(grid->rule);
    setup.grid = std::make_shared<const ZGridTable>(*grid);
  } else {
    settle_noise(options, sensor, setup);
    intrinsics.metres_per_unit = chosen_unit(options, setup, extent_of(cloud, config));
  }
  const auto camera = settle_camera(intrinsics, cloud.width, cloud.height, config);
  if (!camera.ok()) return camera.error();
  auto rays = camera_rays(config.camera);
  if (!rays.ok()) return rays.error();
  setup.rays = std::move(*rays);
  settle_range(options, setup);
  std::vector<std::uint16_t> depth;
  if (!count_cloud(setup, first, Proof::kNone, depth).ok()) return false;
  if (!grid) return true;
  settle_lattice(depth, setup);
  settle_noise(options, sensor, setup);
  return true;
}

// Measures the first frame against grid and rays and takes the misfit off the bound; a reason why
// not, when the cloud does not follow them closely enough.
std::string settle_share(const SensorFrame& first, StreamSetup& setup) {
  StreamConfig& config = setup.encoder.stream;
  std::vector<std::uint16_t> depth;
  (void)count_cloud(setup, first, Proof::kNone, depth);
  const StageOptions& stages = setup.encoder.stages;
  const CloudFit fit = measure_fit(config, setup.rays->table, setup.contract, first.cloud.points,
                                   depth, stages.range_min, stages.range_max);
  if (config.tolerance == ToleranceKind::kLossless) {
    if (setup.grid != nullptr && fit.worst_m <= kExactResidual_m) return {};
    return first.name + ": its coordinates do not follow from a depth grid and a camera";
  }
  if (fit.lateral_share > kMostLateral) {
    return fmt::format(
        "{}: points up to {:.3g} mm off the camera's rays are over a quarter of "
        "their bound",
        first.name, fit.worst_m * 1e3);
  }
  const double share = std::max(kRoom * fit.worst_share, kLeastTaken);
  if (share > kMostTaken) {
    return fmt::format(
        "{}: its depths are too far apart for 65535 steps within the bound; narrow "
        "them with --range",
        first.name);
  }
  setup.allowed_share = share;
  config.tolerance_100nm = static_cast<std::uint32_t>(config.tolerance_100nm * (1 - share));
  config.sigmas_q16 = static_cast<std::uint32_t>(config.sigmas_q16 * (1 - share));
  return {};
}

}  // namespace

Result<Done> setup_cloud(const CodecOptions& options, const SourceSensor& sensor,
                         const SensorFrame& first, StreamSetup& setup) {
  if (const auto fine = check_cloud(first); !fine.ok()) return fine.error();
  setup.cloud_input = true;
  if (has_origin(first.cloud)) return setup_points(options, sensor, first, setup);
  if (!first.cloud.dropped_fields.empty()) {
    setup.notes.push_back(fmt::format("{}: fields not carried by this version: {}", first.name,
                                      fmt::join(first.cloud.dropped_fields, ", ")));
  }
  std::string why;
  Intrinsics intrinsics;
  const auto camera = find_camera(options, first, setup, intrinsics, why);
  if (!camera.ok()) return camera.error();
  bool as_depth = *camera;
  if (as_depth) {
    const auto counted = settle_grid(options, sensor, first, intrinsics, setup);
    if (!counted.ok()) return counted.error();
    as_depth = *counted;
    why = as_depth ? settle_share(first, setup)
                   : first.name + ": some points have no depth in front of the camera";
    as_depth = why.empty();
  }
  if (!as_depth && list_fits(options, setup)) {
    settle_tolerance(options, setup);  // a trial on the grid may have taken something off
    setup.notes.push_back(why + "; coded as a list of points without order");
    return setup_points(options, sensor, first, setup);
  }
  if (!as_depth) {
    make_raw(options, first, setup, why);
    return Done{};
  }
  if (const Extent extent = extent_of(first.cloud, setup.encoder.stream); extent.origins > 0) {
    setup.notes.push_back(fmt::format("{}: {} points at the exact origin are taken as holes",
                                      first.name, extent.origins));
  }
  return Done{};
}

}  // namespace planecast
