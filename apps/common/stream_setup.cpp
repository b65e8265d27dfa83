#include "apps/common/stream_setup.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "apps/common/cloud_counts.hpp"
#include "apps/common/points_setup.hpp"
#include "apps/common/stream_settle.hpp"

namespace planecast {
namespace {

Error other_size(const std::string& name, std::uint32_t width, std::uint32_t height,
                 const CameraModel& camera) {
  return {Status::kUnreadable,
          fmt::format("{}: is {}x{}, but the stream's first frame is {}x{}; encode one size at a "
                      "time",
                      name, width, height, camera.width, camera.height)};
}

// Exact counts need no camera; only the regenerated points do.
Intrinsics nominal_camera(const DepthImage& image, const CodecOptions& options) {
  Intrinsics out;
  out.fx = out.fy = std::max(image.width, image.height);
  out.cx = (image.width - 1) / 2.0;
  out.cy = (image.height - 1) / 2.0;
  if (options.units_m) out.metres_per_unit = *options.units_m;
  return out;
}

Result<Done> setup_depth(const CodecOptions& options, const SourceSensor& sensor,
                         const SensorFrame& first, StreamSetup& setup) {
  StreamConfig& config = setup.encoder.stream;
  const auto given =
      given_camera(options, first.depth.width, first.depth.height, first.name, setup.notes);
  if (!given.ok()) return given.error();
  auto intrinsics = *given;
  if (sensor.intrinsics) intrinsics = sensor.intrinsics;
  if (!intrinsics && config.tolerance == ToleranceKind::kLossless) {
    intrinsics = nominal_camera(first.depth, options);
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
  const auto done = settle_camera(*intrinsics, first.depth.width, first.depth.height, config);
  if (!done.ok()) return done.error();
  settle_lattice(first.depth.depth, setup);
  settle_noise(options, sensor, setup);
  settle_range(options, setup);
  return Done{};
}

// Options that do nothing for the stream: named, not refused.
void name_unused(const CodecOptions& options, StreamSetup& setup) {
  const auto note = [&](const char* name) {
    if (options.is_given(name))
      setup.notes.push_back(fmt::format("--{} has no effect on this input in this version", name));
  };
  note("lidar");
  if (setup.encoder.stream.kind != FrameKind::kDepth) {
    note("effort");
    note("budget-ms");
  }
  if (setup.encoder.stream.kind == FrameKind::kPoints) return;
  for (const char* name : {"regenerate", "alpha", "smoothness", "k", "max-points"}) note(name);
}

// What the first frame is coded as: on its sensor's grid, or as a list of points.
Result<Done> settle_frames(const CodecOptions& options, const SourceSensor& sensor,
                           const SensorFrame& first, StreamSetup& setup) {
  const bool list = options.method == Method::kPaper;
  if (first.depth.width > 0) {
    const auto done = setup_depth(options, sensor, first, setup);
    if (!done.ok() || !list) return done;
    const auto source = settle_list_source(setup.encoder.stream, setup);
    if (!source.ok()) return source.error();
    return setup_points(options, sensor, first, setup);
  }
  if (!list && first.cloud.organised()) return setup_cloud(options, sensor, first, setup);
  if (!first.cloud.dropped_fields.empty()) {
    setup.notes.push_back(fmt::format("{}: fields not carried by this version: {}", first.name,
                                      fmt::join(first.cloud.dropped_fields, ", ")));
  }
  return setup_points(options, sensor, first, setup);
}

}  // namespace

Result<StreamSetup> setup_stream(const CodecOptions& options, const SourceSensor& sensor,
                                 const SensorFrame& first) {
  StreamSetup setup;
  StreamConfig& config = setup.encoder.stream;
  settle_tolerance(options, setup);
  const auto done = settle_frames(options, sensor, first, setup);
  if (!done.ok()) return done.error();
  config.effort_best = options.effort == Effort::kBest && config.kind == FrameKind::kDepth;
  name_unused(options, setup);
  setup.encoder.stages.drop_outliers = options.outliers == Outliers::kDrop;
  setup.encoder.budget_ms = options.budget_ms.value_or(0);
  const double rate = options.rate_hz.value_or(sensor.rate_hz);
  config.period_ms = static_cast<std::uint16_t>(std::round(std::clamp(1000 / rate, 1.0, 60000.0)));
  if (to_fixed(first.pose, config.pose) != Status::kOk) {
    return Error{Status::kUnreadable,
                 first.name +
                     ": its pose is not finite or further than 10^9 m off; mend its "
                     "VIEWPOINT line"};
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
  const CameraModel& camera = setup.encoder.stream.camera;
  const bool cloud = setup.cloud_input;
  const std::uint32_t width = cloud ? frame.cloud.width : frame.depth.width;
  const std::uint32_t height = cloud ? frame.cloud.height : frame.depth.height;
  if (width != camera.width || height != camera.height)
    return other_size(frame.name, width, height, camera);
  if (cloud) return count_cloud(setup, frame, Proof::kMisfit, depth);
  depth = frame.depth.depth;
  return Done{};
}

Result<std::uint32_t> to_raw_points(const StreamSetup& setup, const SensorFrame& frame,
                                    std::vector<Point3f>& points) {
  const CameraModel& camera = setup.encoder.stream.camera;
  if (frame.cloud.width != camera.width || frame.cloud.height != camera.height)
    return other_size(frame.name, frame.cloud.width, frame.cloud.height, camera);
  points = frame.cloud.points;
  std::uint32_t out_of_range = 0;
  if (!setup.raw_range) return out_of_range;
  constexpr float kHole = std::numeric_limits<float>::quiet_NaN();
  for (Point3f& p : points) {
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) continue;
    const double distance = std::hypot(double{p.x}, double{p.y}, double{p.z});
    if (distance >= setup.raw_range->min_m && distance <= setup.raw_range->max_m) continue;
    p = {kHole, kHole, kHole};
    ++out_of_range;
  }
  return out_of_range;
}

}  // namespace planecast
