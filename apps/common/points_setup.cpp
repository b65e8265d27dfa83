// Streams of points without order: what is coded is the list itself, whatever gave it: a file of
// points, an organised cloud that follows no camera, or a depth image treated as a list.
#include "apps/common/points_setup.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "apps/common/stream_settle.hpp"
#include "core/fit/point_rounding.hpp"
#include "core/io/cloud_builder.hpp"
#include "core/metrics/roughness.hpp"
#include "core/model/patch.hpp"

namespace planecast {
namespace {

constexpr double kStepsInBound = 128;      // a finer grid saves nothing worth naming
constexpr double kReachRoom = 1.5;         // over the first frame's largest coordinate
constexpr double kPaperDistance_m = 0.01;  // of a point from its plane, as in the paper's library
constexpr double kLeastSigma_m = 1e-4, kMostSigma_m = 1.0;
constexpr std::uint32_t kRoomPoints = 4096;
constexpr std::uint32_t kSurfaceSlots = 4;
// Decimal steps that files of points are written in [pm].
constexpr std::uint64_t kFileSteps[] = {10'000'000'000, 1'000'000'000, 100'000'000,
                                        10'000'000,     1'000'000,     100'000};

bool in_sigmas(ToleranceKind kind) {
  return kind == ToleranceKind::kSigma || kind == ToleranceKind::kSurfaces;
}

double reach_of(const std::vector<Point3f>& points) {
  double reach = 0;
  for (const Point3f& p : points) {
    for (const float v : {p.x, p.y, p.z}) reach = std::max(reach, std::abs(double{v}));
  }
  return reach;
}

bool lies_on(const std::vector<Point3f>& points, double step_m) {
  return std::all_of(points.begin(), points.end(), [=](const Point3f& p) {
    for (const float v : {p.x, p.y, p.z}) {
      const double steps = std::round(v / step_m);
      if (!(std::abs(steps) <= kMaxGridCoordinate)) return false;
      if (rank_of_float(grid_metres(static_cast<std::int32_t>(steps), step_m)) != rank_of_float(v))
        return false;
    }
    return true;
  });
}

// A grid that gives every coordinate back bit for bit, else the bits themselves.
void settle_exact(const std::vector<Point3f>& points, StreamSetup& setup) {
  PointStream& stream = setup.encoder.stream.points;
  for (const std::uint64_t step : kFileSteps) {
    if (!lies_on(points, static_cast<double>(step) / 1e12)) continue;
    stream.step_pm = step;
    setup.notes.push_back(fmt::format("coordinates are whole multiples of {:g} mm",
                                      static_cast<double>(step) * 1e-9));
    return;
  }
  stream.step_pm = 0;
}

// False: float32 is too coarse for the bound so far from zero.
bool settle_bounded(double reach_m, StreamSetup& setup) {
  PointStream& stream = setup.encoder.stream.points;
  const auto bound_pm = static_cast<double>(point_bound_pm(setup.encoder.stream));
  const double room_m = reach_m * kReachRoom;
  const double least_pm = room_m * 1e12 / kMaxGridCoordinate;
  const double step = std::ceil(std::max({1.0, bound_pm / kStepsInBound, least_pm}));
  if (!(step <= static_cast<double>(kMaxPointStepPm))) return false;
  const double most = tolerance_steps(bound_pm * 1e-12, step * 1e-12, room_m);
  if (!(most >= kStepsInBound / 4)) return false;
  stream.step_pm = static_cast<std::uint64_t>(step);
  stream.tolerance_steps =
      static_cast<std::uint32_t>(std::min(most, 1.0 * kMaxPointToleranceSteps));
  return true;
}

// One sigma for all points: the user's, the sensor's, the paper's, or what the first frame shows.
Result<Done> settle_sigma(const CodecOptions& options, const SourceSensor& sensor,
                          const SensorFrame& first, const std::vector<Point3f>& points,
                          StreamSetup& setup) {
  NoiseModel& noise = setup.encoder.stream.noise;
  noise = {NoiseModel::Kind::kTof, 0};
  const bool needed = in_sigmas(setup.contract.kind);
  const auto given = noise_or_preset(options);
  const auto known = given ? given : sensor.noise;
  if (known && known->kind == NoiseModel::Kind::kTof) {
    noise = *known;
  } else if (given && options.noise && needed) {
    return Error{Status::kUsage,
                 fmt::format("{}: coded as a list of points, which has no depth that --noise {} "
                             "could grow with; give one sigma for all points, e.g. --noise "
                             "tof:0.005, or a bound in metres, e.g. --tolerance 10mm",
                             first.name, to_string(*given))};
  } else if (needed) {
    const bool paper = options.method == Method::kPaper;
    const double found = paper
                             ? kPaperDistance_m / setup.contract.value
                             : std::clamp(surface_roughness_m(points), kLeastSigma_m, kMostSigma_m);
    noise.s_e9 = static_cast<std::uint32_t>(std::llround(std::min(found, 4.0) * 1e9));
    setup.notes.push_back(fmt::format(
        "noise model {} {}; name your own with --noise tof:METRES", to_string(noise),
        paper ? "makes planes 10 mm thick either way" : "from the roughness of its surfaces"));
  }
  setup.contract.noise = noise;
  return Done{};
}

void settle_stages(const CodecOptions& options, StreamSetup& setup) {
  StageOptions& stages = setup.encoder.stages;
  if (options.range) {
    stages.range_min_m = options.range->min_m;
    stages.range_max_m = options.range->max_m;
  }
  stages.range_min = 0;
  stages.range_max = 65535;
  stages.paper = options.method == Method::kPaper;
  stages.neighbours = options.k;
  stages.smoothness_deg = options.smoothness_deg;
  stages.seed = options.seed;
  stages.outlier_deviations = options.method == Method::kPaper ? 1 : 3;
  // Neighbours and surfaces of a frame stay with its slot: fewer slots where there are some.
  if (setup.encoder.stream.tolerance == ToleranceKind::kSurfaces)
    setup.encoder.runner.slots = std::min(setup.encoder.runner.slots, kSurfaceSlots);
}

std::uint32_t most_points(const CodecOptions& options, std::size_t in_first) {
  if (options.max_points) return *options.max_points;
  // A quarter more, for later frames of the same sensor.
  const std::uint64_t room = in_first + in_first / 4;
  return static_cast<std::uint32_t>(
      std::min<std::uint64_t>((room / kRoomPoints + 1) * kRoomPoints, kMaxFramePoints));
}

Error too_many(const SensorFrame& frame, std::size_t points, std::uint32_t most) {
  return {Status::kFrameTooLarge,
          fmt::format("{}: has {} points, more than the {} that memory was taken for; name "
                      "--max-points {}",
                      frame.name, points, most, points)};
}

// Points of a depth image along its camera's rays.
struct DepthPoints {
  StreamConfig config;
  std::shared_ptr<const CameraRays> rays;
  Arena arena;
  DepthScale scale;
};

}  // namespace

struct ListSource {
  DepthPoints depth;
};

Result<Done> settle_list_source(const StreamConfig& depth, StreamSetup& setup) {
  auto source = std::make_shared<ListSource>();
  DepthPoints& d = source->depth;
  d.config = depth;
  auto rays = camera_rays(depth.camera);
  if (!rays.ok()) return rays.error();
  d.rays = std::move(*rays);
  auto arena = Arena::map(std::size_t{1} << 19U);
  if (!arena.ok()) return arena.error();
  d.arena = std::move(*arena);
  d.scale.layout(d.arena);
  d.scale.build(depth);
  setup.list_source = std::move(source);
  return Done{};
}

namespace {

Result<std::vector<Point3f>> raw_list(const StreamSetup& setup, const SensorFrame& frame) {
  if (frame.depth.width == 0) return frame.cloud.points;
  const DepthPoints& d = setup.list_source->depth;
  std::vector<Point3f> out(frame.depth.depth.size());
  const Status status = regenerate(d.config, d.rays->table, d.scale, frame.depth.depth, out);
  if (status != Status::kOk)
    return Error{Status::kUnreadable,
                 frame.name + ": is of another size than the frames before it"};
  return out;
}

}  // namespace

Result<Done> setup_points(const CodecOptions& options, const SourceSensor& sensor,
                          const SensorFrame& first, StreamSetup& setup) {
  StreamConfig& config = setup.encoder.stream;
  auto list = raw_list(setup, first);
  if (!list.ok()) return list.error();
  std::vector<Point3f>& points = *list;
  if (points.empty()) {
    return Error{Status::kUnreadable,
                 first.name + ": holds no point; check that it is the file that was meant"};
  }
  std::erase_if(points, [](const Point3f& p) { return !is_valid(p); });
  if (points.size() > kMaxFramePoints) {
    return Error{Status::kUnreadable, fmt::format("{}: has {} points, of which {} can be coded as "
                                                  "one frame; cut it",
                                                  first.name, points.size(), kMaxFramePoints)};
  }
  config.kind = FrameKind::kPoints;
  config.camera = {};
  config.lattice = {};
  config.z_rule = ZRule::kProductInDouble;
  config.mirror_y = false;
  config.axes = {};
  config.axes.t_um = {std::llround(first.cloud.origin_x * 1e6),
                      std::llround(first.cloud.origin_y * 1e6),
                      std::llround(first.cloud.origin_z * 1e6)};
  config.points = {};
  config.points.max_points = most_points(options, points.size());
  if (points.size() > config.points.max_points)
    return too_many(first, points.size(), config.points.max_points);
  if (const auto done = settle_sigma(options, sensor, first, points, setup); !done.ok())
    return done;
  config.points.patch_unit_nm = patch_unit_nm(options.alpha_m);
  config.points.fill =
      options.regenerate == Regenerate::kRandom ? FillMode::kRandom : FillMode::kLattice;
  config.points.seed = static_cast<std::uint32_t>(options.seed);
  if (config.tolerance == ToleranceKind::kLossless) {
    settle_exact(points, setup);
  } else if (!settle_bounded(reach_of(points), setup)) {
    setup.notes.push_back(fmt::format(
        "{}: its coordinates are too large for float32 to keep the bound; their bits are coded "
        "losslessly",
        first.name));
    config.tolerance = ToleranceKind::kLossless;
    config.drop_off_surface = false;
    config.points.step_pm = 0;
    setup.contract = {};
    setup.bound_m = 0;
  }
  settle_stages(options, setup);
  setup.rays.reset();
  setup.grid.reset();
  setup.allowed_share = 0;
  setup.cloud_input = true;
  return Done{};
}

void set_origin(const StreamConfig& config, PointCloud& cloud) {
  cloud.origin_x = static_cast<double>(config.axes.t_um[0]) / 1e6;
  cloud.origin_y = static_cast<double>(config.axes.t_um[1]) / 1e6;
  cloud.origin_z = static_cast<double>(config.axes.t_um[2]) / 1e6;
}

Result<Done> to_points(const StreamSetup& setup, const SensorFrame& frame,
                       std::vector<Point3f>& points) {
  auto list = raw_list(setup, frame);
  if (!list.ok()) return list.error();
  points = std::move(*list);
  std::erase_if(points, [](const Point3f& p) { return !is_valid(p); });
  const StreamConfig& config = setup.encoder.stream;
  if (points.size() > config.points.max_points)
    return too_many(frame, points.size(), config.points.max_points);
  PointCloud stream;
  set_origin(config, stream);
  const double x = frame.cloud.origin_x - stream.origin_x;
  const double y = frame.cloud.origin_y - stream.origin_y;
  const double z = frame.cloud.origin_z - stream.origin_z;
  if (x == 0 && y == 0 && z == 0) return Done{};
  if (std::abs(x) > kOriginThreshold || std::abs(y) > kOriginThreshold ||
      std::abs(z) > kOriginThreshold) {
    return Error{Status::kBoundExceeded,
                 fmt::format("{}: lies over {:g} km from the stream's first frame; encode it as a "
                             "stream of its own",
                             frame.name, kOriginThreshold * 1e-3)};
  }
  for (Point3f& p : points)
    p = {static_cast<float>(p.x + x), static_cast<float>(p.y + y), static_cast<float>(p.z + z)};
  return Done{};
}

}  // namespace planecast
