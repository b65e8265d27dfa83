// planecast compare: how far apart two clouds are.
#include <fmt/core.h>

#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>

#include "apps/common/stream_settle.hpp"
#include "apps/planecast/commands.hpp"
#include "apps/planecast/describe.hpp"
#include "core/base/arena.hpp"
#include "core/io/cloud_builder.hpp"
#include "core/metrics/distance.hpp"
#include "core/regen/regenerate.hpp"

namespace planecast {
namespace {

// The points of a depth image, by the camera of the options.
Result<std::vector<Point3f>> points_of_depth(const SensorFrame& frame,
                                             const CodecOptions& options) {
  std::vector<std::string> notes;
  const auto given =
      given_camera(options, frame.depth.width, frame.depth.height, frame.name, notes);
  if (!given.ok()) return given.error();
  tell(notes);
  if (!given->has_value()) {
    return Error{Status::kUsage, frame.name +
                                     ": a depth image needs its camera to be compared: --camera "
                                     "FX,FY,CX,CY[,METRES_PER_UNIT] or a preset's name"};
  }
  StreamConfig config;
  const auto settled = settle_camera(**given, frame.depth.width, frame.depth.height, config);
  if (!settled.ok()) return settled.error();
  const auto rays = camera_rays(config.camera);
  if (!rays.ok()) return rays.error();
  auto arena = Arena::map(std::size_t{1} << 19U);
  if (!arena.ok()) return arena.error();
  DepthScale scale;
  scale.layout(*arena);
  scale.build(config);
  std::vector<Point3f> points(frame.depth.depth.size());
  const Status status = regenerate(config, (*rays)->table, scale, frame.depth.depth, points);
  if (status != Status::kOk) return Error{status, frame.name + ": could not be turned into points"};
  return points;
}

struct ComparedCloud {
  std::string name;
  std::uint32_t width = 0, height = 0;
  std::vector<Point3f> points;
  Point3d zero;  ///< of the points, in the file's coordinates
};

// Brings b's points to a's zero, in double; each cloud has its own when its offsets are large.
void align(const ComparedCloud& a, ComparedCloud& b) {
  const double x = b.zero.x - a.zero.x, y = b.zero.y - a.zero.y, z = b.zero.z - a.zero.z;
  if (x == 0 && y == 0 && z == 0) return;
  for (Point3f& p : b.points)
    p = {static_cast<float>(p.x + x), static_cast<float>(p.y + y), static_cast<float>(p.z + z)};
}

Result<ComparedCloud> load(const std::string& path, const CodecOptions& options) {
  auto source = open_source({path}, options);
  if (!source.ok()) return source.error();
  if ((*source)->count() != 1)
    return Error{Status::kUsage, path + ": compare takes two single clouds, not folders"};
  SensorFrame frame;
  const auto got = (*source)->next(frame);
  if (!got.ok()) return got.error();
  if (frame.depth.width > 0) {
    auto points = points_of_depth(frame, options);
    if (!points.ok()) return points.error();
    return ComparedCloud{path, frame.depth.width, frame.depth.height, std::move(*points), {}};
  }
  PointCloud& cloud = frame.cloud;
  std::size_t origins = 0;
  for (Point3f& p : cloud.points) {
    // A list has no holes: a point at zero is a point.
    if (!cloud.organised() || is_depth_reading(p) || !is_valid(p)) continue;
    p.x = p.y = p.z = std::numeric_limits<float>::quiet_NaN();
    ++origins;
  }
  if (origins > 0)
    tell({fmt::format("{}: {} points at the exact origin are taken as holes", path, origins)});
  return ComparedCloud{path,
                       cloud.width,
                       cloud.height,
                       std::move(cloud.points),
                       {cloud.origin_x, cloud.origin_y, cloud.origin_z}};
}

Json number(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

Json figures_of(const CloudDistance& far, const std::optional<CorrespondingDistance>& pairs) {
  Json out = {{"points_a", far.points_a},
              {"points_b", far.points_b},
              {"d1_ab_mm", number(far.d1_ab * 1e3)},
              {"d1_ba_mm", number(far.d1_ba * 1e3)},
              {"d1_mm", number(far.d1 * 1e3)},
              {"d2_mm", number(far.d2 * 1e3)},
              {"max_mm", number(far.hausdorff * 1e3)}};
  if (!pairs) return out;
  out["max_corresponding_mm"] = number(pairs->max * 1e3);
  out["rmse_corresponding_mm"] = number(pairs->rmse * 1e3);
  out["compared"] = pairs->compared;
  out["only_a"] = pairs->only_original;
  out["only_b"] = pairs->only_decoded;
  return out;
}

Result<double> limit_of(const CommandArguments& arguments) {
  if (arguments.max_error.empty()) return std::numeric_limits<double>::infinity();
  if (arguments.max_error == "0") return 0.0;
  const auto limit = parse_length(arguments.max_error);
  if (!limit.ok()) return Error{Status::kUsage, "--max-error: " + limit.error().message};
  return limit;
}

}  // namespace

ExitCode run_compare(const CommandArguments& arguments, const CodecOptions& options) {
  if (arguments.inputs.size() != 2) {
    return complain({Status::kUsage, fmt::format("compare: takes two clouds, A and B; {} given",
                                                 arguments.inputs.size())});
  }
  const auto limit = limit_of(arguments);
  if (!limit.ok()) return complain(limit.error());
  const auto a = load(arguments.inputs[0], options);
  if (!a.ok()) return complain(a.error());
  auto b = load(arguments.inputs[1], options);
  if (!b.ok()) return complain(b.error());
  align(*a, *b);

  const CloudDistance far = cloud_distance(a->points, b->points);
  std::optional<CorrespondingDistance> pairs;
  if (a->height > 1 && a->width == b->width && a->height == b->height) {
    const auto compared = max_corresponding(a->points, b->points);
    if (compared.ok()) pairs = *compared;
  }
  const Json figures = figures_of(far, pairs);
  fmt::print("{}\n", arguments.json ? figures.dump(2) : readable(figures));
  const double worst = std::max(far.hausdorff, pairs ? pairs->max : 0.0);
  if (worst <= *limit) return ExitCode::kDone;
  tell({fmt::format("{} and {} are {:.6g} mm apart at the most, over --max-error {}",
                    arguments.inputs[0], arguments.inputs[1], worst * 1e3, arguments.max_error)});
  return ExitCode::kBoundExceeded;
}

}  // namespace planecast
