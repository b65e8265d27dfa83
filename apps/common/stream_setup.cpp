#include "apps/common/stream_setup.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/fit/lattice_fit.hpp"
#include "core/sensor/estimate_camera.hpp"
#include "core/sensor/z_grid.hpp"

namespace planecast {
namespace {

constexpr double kExactResidual = 2e-6;  // [m] x and y of a lossless grid cloud
constexpr double kLongestRay = 2.0;      // |(x, y, 1)| beyond which half a count is not budgeted

bool valid(const Point3f& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

// Optical coordinates of a cloud's point: the inverse of config.axes and mirror_y.
struct OpticalAxes {
  double m[3][3];
  double t[3];
  bool flip;

  explicit OpticalAxes(const StreamConfig& config) : flip(config.mirror_y) {
    const Pose p = to_pose(config.axes);
    const double w = p.qw, x = p.qx, y = p.qy, z = p.qz;
    const double r[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
                            {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
                            {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}};
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) m[i][j] = r[j][i];
    }
    t[0] = p.tx;
    t[1] = p.ty;
    t[2] = p.tz;
  }
  double z(const Point3f& p) const {
    return m[2][0] * (p.x - t[0]) + m[2][1] * (p.y - t[1]) + m[2][2] * (p.z - t[2]);
  }
};

void set_tolerance(const CodecOptions& options, StreamConfig& config) {
  config.tolerance = options.tolerance.kind;
  switch (options.tolerance.kind) {
    case ToleranceKind::kLossless:
      break;
    case ToleranceKind::kMetres:
      config.tolerance_100nm =
          static_cast<std::uint32_t>(std::min(options.tolerance.value * 1e7, 4.0e9));
      break;
    case ToleranceKind::kSigma:
    case ToleranceKind::kSurfaces:
      config.sigmas_q16 = static_cast<std::uint32_t>(std::lround(options.tolerance.value * 65536));
      break;
  }
  config.drop_off_surface =
      options.off_surface == OffSurface::kDrop && config.tolerance == ToleranceKind::kSurfaces;
  config.effort_best = options.effort == Effort::kBest;
}

// A noise model for a sensor nobody named: one level of its lattice, or time of flight.
NoiseModel default_noise(const StreamConfig& config, std::vector<std::string>& notes) {
  NoiseModel noise;
  if (config.lattice.present()) {
    const double c_m =
        config.lattice.c_q8 / 256.0 * static_cast<double>(config.camera.unit_pm) * 1e-12;
    noise.kind = NoiseModel::Kind::kStereo;
    noise.s_e9 = static_cast<std::uint32_t>(std::clamp(std::lround(1e9 / c_m), 1L, 4'000'000'000L));
    notes.push_back(fmt::format(
        "noise model {} from the lattice's spacing; name your own with --noise", to_string(noise)));
  } else {
    noise.kind = NoiseModel::Kind::kTof;
    noise.s_e9 = 5'000'000;
    notes.push_back(
        fmt::format("noise model {} assumed; name your own with --noise", to_string(noise)));
  }
  return noise;
}

Result<Done> settle_noise(const CodecOptions& options, const SourceSensor& sensor,
                          StreamSetup& setup) {
  StreamConfig& config = setup.encoder.stream;
  if (const auto given = noise_or_preset(options)) {
    config.noise = *given;
  } else if (sensor.noise) {
    config.noise = *sensor.noise;
  } else {
    std::vector<std::string> quiet;
    const bool needed =
        config.tolerance == ToleranceKind::kSigma || config.tolerance == ToleranceKind::kSurfaces;
    config.noise = default_noise(config, needed ? setup.notes : quiet);
  }
  return Done{};
}

void settle_lattice(const std::vector<std::uint16_t>& depth, StreamSetup& setup) {
  StreamConfig& config = setup.encoder.stream;
  if (const auto lattice = find_lattice(depth)) {
    config.lattice = *lattice;
    setup.notes.push_back(fmt::format("depth lies on a lattice: C = {:.3f} counts, offset {:.5f}{}",
                                      lattice->c_q8 / 256.0, lattice->offset_q16 / 65536.0,
                                      lattice->truncated ? ", cut" : ""));
  }
}

Result<Done> set_camera(const Intrinsics& intrinsics, std::uint32_t width, std::uint32_t height,
                        StreamConfig& config) {
  const auto camera = quantise(intrinsics, width, height);
  if (!camera.ok()) return camera.error();
  config.camera = *camera;
  return Done{};
}

// The smallest bound any reading of the cloud has [m]; 0 for lossless.
double smallest_bound(const StreamConfig& config, const CodecOptions& options, double nearest_m) {
  switch (config.tolerance) {
    case ToleranceKind::kMetres:
      return options.tolerance.value;
    case ToleranceKind::kSigma:
    case ToleranceKind::kSurfaces:
      return options.tolerance.value * config.noise.sigma_m(nearest_m);
    case ToleranceKind::kLossless:
      break;
  }
  return 0;
}

void make_raw(const SensorFrame& first, StreamSetup& setup, const std::string& why) {
  StreamConfig& config = setup.encoder.stream;
  config.kind = FrameKind::kRawCloud;
  config.lattice = {};
  config.axes = {};
  config.mirror_y = false;
  Intrinsics any;
  any.fx = any.fy = first.cloud.width;
  any.cx = first.cloud.width / 2.0;
  any.cy = first.cloud.height / 2.0;
  (void)set_camera(any, first.cloud.width, first.cloud.height, config);
  setup.notes.push_back(why + "; its float32 coordinates are coded losslessly");
}

Result<Done> setup_cloud(const CodecOptions& options, const SourceSensor& sensor,
                         const SensorFrame& first, StreamSetup& setup) {
  StreamConfig& config = setup.encoder.stream;
  const PointCloud& cloud = first.cloud;
  if (!cloud.organised()) {
    return Error{
        Status::kUnreadable,
        first.name +
            ": is not organised (height 1); this version codes organised clouds and depth images"};
  }
  if (cloud.width > kMaxImageSide || cloud.height > kMaxImageSide) {
    return Error{Status::kUnreadable, fmt::format("{}: {}x{} is larger than {} a side", first.name,
                                                  cloud.width, cloud.height, kMaxImageSide)};
  }
  setup.cloud_input = true;
  double nearest = 1e9, farthest = 0;
  Intrinsics intrinsics;
  double residual = 0;
  if (const auto given = intrinsics_of(options)) {
    intrinsics = *given;
  } else {
    const auto estimated = estimate_camera(cloud);
    if (!estimated.ok()) {
      make_raw(first, setup, first.name + ": " + estimated.error().message);
      return settle_noise(options, sensor, setup);
    }
    intrinsics = estimated->intrinsics;
    residual = estimated->max_residual_m;
    config.mirror_y = estimated->mirror_y;
    if (const Status status = to_fixed(estimated->cloud_from_optical, config.axes);
        status != Status::kOk) {
      make_raw(first, setup, first.name + ": the estimated axes are out of range");
      return settle_noise(options, sensor, setup);
    }
    setup.notes.push_back("camera estimated: " + estimated->describe());
  }
  const OpticalAxes axes(config);
  for (const Point3f& p : cloud.points) {
    if (!valid(p)) continue;
    nearest = std::min(nearest, axes.z(p));
    farthest = std::max(farthest, axes.z(p));
  }
  const bool optical = config.axes == PoseFixed{} && !config.mirror_y;
  const auto grid = optical ? find_z_grid(cloud) : std::nullopt;
  double rounding = 0;
  if (grid) {
    intrinsics.metres_per_unit = static_cast<double>(grid->unit_pm) * 1e-12;
    config.z_rule = static_cast<ZRule>(grid->rule);
    setup.exact_grid = true;
  } else {
    // Counts as fine as the farthest point allows; their rounding is taken off the bound.
    const double unit = std::max(farthest / 65000.0, 1e-5);
    intrinsics.metres_per_unit = std::ceil(unit * 1e6) * 1e-6;
    rounding = intrinsics.metres_per_unit / 2 * kLongestRay;
  }
  if (const auto camera = set_camera(intrinsics, cloud.width, cloud.height, config); !camera.ok())
    return camera.error();
  if (grid) {
    std::vector<std::uint16_t> depth;
    if (const auto done = to_depth(setup, first, depth); !done.ok()) return done.error();
    settle_lattice(depth, setup);
  }
  if (const auto done = settle_noise(options, sensor, setup); !done.ok()) return done.error();
  const double bound = smallest_bound(config, options, nearest);
  const double taken = residual + rounding;
  const bool lossless = config.tolerance == ToleranceKind::kLossless;
  if (lossless && (!grid || residual > kExactResidual)) {
    make_raw(first, setup,
             first.name + ": its coordinates do not follow from a depth grid and a camera");
    return Done{};
  }
  if (!lossless && (residual > bound / 4 || taken > bound / 2 || nearest <= 0)) {
    make_raw(first, setup,
             fmt::format("{}: {:.3g} mm off a camera's rays is over a quarter of the bound",
                         first.name, residual * 1e3));
    return Done{};
  }
  if (config.tolerance == ToleranceKind::kMetres) {
    config.tolerance_100nm = static_cast<std::uint32_t>(std::max(0.0, (bound - taken) * 1e7));
  } else if (!lossless) {
    config.sigmas_q16 = static_cast<std::uint32_t>(config.sigmas_q16 * (1 - taken / bound));
  }
  return Done{};
}

Result<Done> setup_depth(const CodecOptions& options, const SourceSensor& sensor,
                         const SensorFrame& first, StreamSetup& setup) {
  StreamConfig& config = setup.encoder.stream;
  auto intrinsics = intrinsics_of(options);
  if (!intrinsics) intrinsics = sensor.intrinsics;
  if (!intrinsics && config.tolerance == ToleranceKind::kLossless) {
    // Exact counts need no camera; only the regenerated points do.
    intrinsics = Intrinsics{};
    intrinsics->fx = intrinsics->fy = std::max(first.depth.width, first.depth.height);
    intrinsics->cx = (first.depth.width - 1) / 2.0;
    intrinsics->cy = (first.depth.height - 1) / 2.0;
    setup.notes.push_back(fmt::format(
        "no camera given: depth comes back exactly, points are regenerated with a nominal focal "
        "length of {} px; name yours with --camera",
        intrinsics->fx));
  }
  if (!intrinsics) {
    return Error{
        Status::kUsage,
        first.name +
            ": a depth image needs its camera: --camera FX,FY,CX,CY[,METRES_PER_UNIT] or a preset "
            "such as --camera realsense-d435"};
  }
  if (const auto camera = set_camera(*intrinsics, first.depth.width, first.depth.height, config);
      !camera.ok())
    return camera.error();
  settle_lattice(first.depth.depth, setup);
  return settle_noise(options, sensor, setup);
}

void settle_range(const CodecOptions& options, StreamSetup& setup) {
  if (!options.range) return;
  const double unit = static_cast<double>(setup.encoder.stream.camera.unit_pm) * 1e-12;
  StageOptions& stages = setup.encoder.stages;
  stages.range_min = static_cast<std::uint16_t>(
      std::clamp(std::ceil(options.range->min_m / unit - 1e-6), 0.0, 65535.0));
  stages.range_max = static_cast<std::uint16_t>(
      std::clamp(std::floor(options.range->max_m / unit + 1e-6), 0.0, 65535.0));
}

}  // namespace

Result<StreamSetup> setup_stream(const CodecOptions& options, const SourceSensor& sensor,
                                 const SensorFrame& first) {
  StreamSetup setup;
  StreamConfig& config = setup.encoder.stream;
  set_tolerance(options, config);
  setup.bound_m = options.tolerance.kind == ToleranceKind::kMetres ? options.tolerance.value : 0;
  const auto done = first.depth.width > 0 ? setup_depth(options, sensor, first, setup)
                                          : setup_cloud(options, sensor, first, setup);
  if (!done.ok()) return done.error();
  settle_range(options, setup);
  setup.encoder.stages.drop_outliers = options.outliers == Outliers::kDrop;
  const double rate = options.rate_hz.value_or(sensor.rate_hz);
  config.period_ms = static_cast<std::uint16_t>(std::clamp(std::lround(1000 / rate), 1L, 60000L));
  if (to_fixed(first.pose, config.pose) != Status::kOk) {
    return Error{Status::kBadConfig, first.name + ": its pose is not finite"};
  }
  const std::string& id = first.frame_id.empty() ? options.name : first.frame_id;
  std::strncpy(config.frame_id.data(), id.c_str(), kMaxFrameIdBytes);
  if (const Status status = check_config(config); status != Status::kOk) {
    return Error{
        Status::kBadConfig,
        "the stream's settings are out of range: check --camera, --noise, --tolerance and --name"};
  }
  return setup;
}

Result<Done> to_depth(const StreamSetup& setup, const SensorFrame& frame,
                      std::vector<std::uint16_t>& depth) {
  const StreamConfig& config = setup.encoder.stream;
  if (!setup.cloud_input) {
    if (frame.depth.width != config.camera.width || frame.depth.height != config.camera.height) {
      return Error{Status::kUnreadable,
                   frame.name + ": its size differs from the stream's first frame"};
    }
    depth = frame.depth.depth;
    return Done{};
  }
  if (frame.cloud.width != config.camera.width || frame.cloud.height != config.camera.height) {
    return Error{Status::kUnreadable,
                 frame.name + ": its size differs from the stream's first frame"};
  }
  const ZGrid grid{config.camera.unit_pm, static_cast<ZGrid::Rule>(config.z_rule)};
  const OpticalAxes axes(config);
  const double unit = static_cast<double>(config.camera.unit_pm) * 1e-12;
  depth.assign(frame.cloud.points.size(), 0);
  for (std::size_t i = 0; i < depth.size(); ++i) {
    const Point3f& p = frame.cloud.points[i];
    if (!valid(p)) continue;
    const double counts = setup.exact_grid ? grid_count(grid, p.z) : std::round(axes.z(p) / unit);
    if (counts < 1 || counts > 65535) {
      return Error{Status::kUnreadable, fmt::format("{}: point {} at z = {} m is off the stream's "
                                                    "depth grid; encode it as a stream of its own",
                                                    frame.name, i, p.z)};
    }
    depth[i] = static_cast<std::uint16_t>(counts);
  }
  return Done{};
}

}  // namespace planecast
