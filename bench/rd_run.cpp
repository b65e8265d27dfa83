#include "bench/rd_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <ctime>
#include <limits>
#include <map>

#include "apps/common/frame_codec.hpp"
#include "bench/baselines/depth_baselines.hpp"
#include "bench/baselines/point_baselines.hpp"
#include "core/metrics/distance.hpp"

namespace planecast::bench {
namespace {

using baselines::Bytes;
using baselines::PointList;

constexpr int kTimes = 5, kWarmUps = 2;
constexpr int kBisections = 8;
constexpr double kLadder_mm[] = {1, 2, 5, 10, 20, 30, 50, 100};

bool finite(const Point3f& p) {
  return std::isfinite(p.z);
}

PointList finite_points(const std::vector<Point3f>& grid) {
  PointList out;
  std::copy_if(grid.begin(), grid.end(), std::back_inserter(out), finite);
  return out;
}

double process_cpu_ms() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) * 1e3 + static_cast<double>(now.tv_nsec) * 1e-6;
}

template <class F>
double median_of_runs(F&& f) {
  std::vector<double> ms;
  for (int i = 0; i < kTimes + kWarmUps; ++i) {
    const double begin = process_cpu_ms();
    f();
    if (i >= kWarmUps) ms.push_back(process_cpu_ms() - begin);
  }
  return median_ms(std::move(ms));
}

std::size_t merged_points(PointList points) {
  const auto less = [](const Point3f& a, const Point3f& b) {
    return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
  };
  const auto same = [](const Point3f& a, const Point3f& b) {
    return a.x == b.x && a.y == b.y && a.z == b.z;
  };
  std::sort(points.begin(), points.end(), less);
  return static_cast<std::size_t>(points.end() - std::unique(points.begin(), points.end(), same));
}

// `far` has what the search found; `max_m` is the Hausdorff distance unless the order is known.
RdDistance distance_of(const CloudDistance& far, const PointList& decoded) {
  RdDistance out;
  out.points_out = decoded.size();
  out.merged = merged_points(decoded);
  out.d1_ab_m = far.d1_ab;
  out.d1_ba_m = far.d1_ba;
  out.d1_m = far.d1;
  out.d2_m = far.d2;
  out.max_m = far.hausdorff;
  return out;
}

RdDistance grid_distance(const RdFrame& frame, const std::vector<Point3f>& grid) {
  const PointList decoded = finite_points(grid);
  const auto pairs = max_corresponding(frame.grid, grid);
  if (!pairs.ok()) throw std::runtime_error(pairs.error().message);
  CloudDistance far;
  if (pairs->max > 0 || pairs->only_original + pairs->only_decoded > 0)
    far = cloud_distance(frame.points, decoded);
  RdDistance out = distance_of(far, decoded);
  out.max_m = pairs->max;
  return out;
}

// A reading keeps its ray: its point moves towards or away from the sensor.
std::vector<Point3f> points_of(const RdFrame& frame, const DepthImage& decoded) {
  if (decoded.depth.size() != frame.depth.depth.size())
    throw std::runtime_error("an image of another size came back");
  constexpr float kHole = std::numeric_limits<float>::quiet_NaN();
  std::vector<Point3f> out(frame.grid.size(), Point3f{kHole, kHole, kHole});
  for (std::size_t i = 0; i < out.size(); ++i) {
    const std::uint16_t was = frame.depth.depth[i], is = decoded.depth[i];
    if ((was == 0) != (is == 0)) throw std::runtime_error("a hole came back as a reading, or not");
    if (was == 0) continue;
    const double scale = double{static_cast<double>(is)} / was;
    const Point3f& p = frame.grid[i];
    out[i] = {static_cast<float>(p.x * scale), static_cast<float>(p.y * scale),
              static_cast<float>(p.z * scale)};
  }
  return out;
}

std::string millimetres(double bound_m) {
  return fmt::format("{:.4g}mm", bound_m * 1e3);
}

RdRow own_row(const CodecOptions& options, const RdFrame& frame, const Tolerance& tolerance,
              const std::string& setting) {
  const OwnResult own = run_own(options, frame.sensor, frame.frame, tolerance, true);
  RdRow row;
  row.codec = options.effort == Effort::kBest ? "planecast best" : "planecast fast";
  row.setting = setting;
  row.ours = true;
  row.bytes = own.bytes;
  row.distance = grid_distance(frame, own.cloud);
  row.encode_ms = own.encode_ms;
  row.decode_ms = own.decode_ms;
  return row;
}

Tolerance metres(double bound_m) {
  Tolerance tolerance;
  tolerance.kind = ToleranceKind::kMetres;
  tolerance.value = bound_m;
  return tolerance;
}

// The largest bound whose d1 is at most `target_mm`, between the rungs of the ladder round it; d1
// grows with the bound but for small waves.
double bound_for(const CodecOptions& options, const RdFrame& frame, double target_mm,
                 const std::vector<RdRow>& ladder) {
  double low = kLadder_mm[0] * 1e-4, high = 0;
  for (std::size_t i = 0; i < std::size(kLadder_mm) && high == 0; ++i) {
    (ladder[i].distance.d1_m * 1e3 <= target_mm ? low : high) = kLadder_mm[i] * 1e-3;
  }
  if (high == 0) high = low * 10;
  for (int i = 0; i < kBisections; ++i) {
    const double middle = std::sqrt(low * high);
    const OwnResult own = run_own(options, frame.sensor, frame.frame, metres(middle), false);
    DistanceOptions fast;
    fast.point_to_plane = false;
    const double d1 = cloud_distance(frame.points, finite_points(own.cloud), fast).d1;
    (d1 * 1e3 <= target_mm ? low : high) = middle;
  }
  return low;
}

template <class Data>
RdRow coded_row(const baselines::Baseline<Data>& codec, const Data& data, Bytes& bytes) {
  bytes = codec.encode(data);
  RdRow row;
  row.codec = codec.name();
  row.setting = codec.setting();
  row.bytes = bytes.size();
  row.encode_ms = median_of_runs([&] { (void)codec.encode(data); });
  row.decode_ms = median_of_runs([&] { (void)codec.decode(bytes); });
  return row;
}

bool wanted(const std::string& name, const std::string& only) {
  return only.empty() || name.find(only) != std::string::npos;
}

void depth_rows(const RdFrame& frame, const std::string& only, std::vector<RdRow>& rows,
                std::vector<std::string>& skipped) {
  std::map<std::vector<std::uint16_t>, RdDistance> known;  // of lossless codecs on the same steps
  for (const auto& codec : baselines::depth_set(skipped)) {
    if (!wanted(codec->name(), only)) continue;
    Bytes bytes;
    RdRow row = coded_row(*codec, frame.depth, bytes);
    const DepthImage decoded = codec->decode(bytes);
    const auto found = known.find(decoded.depth);
    row.distance =
        found != known.end() ? found->second : grid_distance(frame, points_of(frame, decoded));
    known.emplace(decoded.depth, row.distance);
    rows.push_back(std::move(row));
  }
}

void draco_rows(const RdFrame& frame, const std::string& only, std::vector<RdRow>& rows,
                std::vector<std::string>& skipped) {
  if (!baselines::draco_available()) {
    skipped.emplace_back("Draco (libdraco-dev)");
    return;
  }
  const struct {
    bool kd;
    int level;
  } sets[] = {{true, 3}, {true, 7}, {true, 10}, {false, 7}};
  for (int bits = 6; bits <= 13; ++bits) {
    std::optional<RdDistance> known;  // the same for every level: only the rounding loses anything
    for (const auto& set : sets) {
      const auto codec = baselines::draco_points(set.kd, set.level, bits);
      if (!wanted(codec->name(), only)) continue;
      Bytes bytes;
      RdRow row = coded_row(*codec, frame.points, bytes);
      const PointList decoded = codec->decode(bytes);
      if (!known) known = distance_of(cloud_distance(frame.points, decoded), decoded);
      row.distance = *known;
      row.distance.points_out = decoded.size();
      rows.push_back(std::move(row));
    }
  }
}

}  // namespace

RdFrame prepare_frame(const CodecOptions& options, const SourceSensor& sensor, SensorFrame frame) {
  RdFrame out;
  out.sensor = sensor;
  OwnResult own = run_own(options, sensor, frame, Tolerance{ToleranceKind::kLossless, 0}, false);
  if (own.depth.empty()) throw std::runtime_error(frame.name + ": is no depth image");
  const bool cloud = frame.cloud.width > 0;
  out.depth.width = cloud ? frame.cloud.width : frame.depth.width;
  out.depth.height = cloud ? frame.cloud.height : frame.depth.height;
  for (std::size_t i = 0; i < frame.depth.depth.size(); ++i) {
    if (own.depth[i] != 0 && own.depth[i] != frame.depth.depth[i])
      throw std::runtime_error(frame.name + ": our lossless mode is not");
  }
  out.depth.depth = std::move(own.depth);
  out.grid = std::move(own.cloud);
  out.points = finite_points(out.grid);
  out.frame = std::move(frame);
  return out;
}

std::vector<RdRow> own_rows(const CodecOptions& options, const RdFrame& frame,
                            const std::vector<double>& targets_mm) {
  std::vector<RdRow> rows;
  for (const double mm : kLadder_mm)
    rows.push_back(own_row(options, frame, metres(mm * 1e-3), millimetres(mm * 1e-3)));
  const std::vector<RdRow> ladder = rows;
  rows.push_back(own_row(options, frame, {ToleranceKind::kLossless, 0}, "lossless"));
  rows.push_back(own_row(options, frame, {ToleranceKind::kSigma, 2}, "2sigma"));
  for (const double target : targets_mm) {
    const double bound = bound_for(options, frame, target, ladder);
    rows.push_back(own_row(options, frame, metres(bound), millimetres(bound)));
    rows.back().target_d1_mm = target;
  }
  return rows;
}

std::vector<RdRow> peer_rows(const RdFrame& frame, const std::string& only,
                             std::vector<std::string>& skipped) {
  std::vector<RdRow> rows;
  depth_rows(frame, only, rows, skipped);
  draco_rows(frame, only, rows, skipped);
  return rows;
}

}  // namespace planecast::bench
