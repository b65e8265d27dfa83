#include "apps/planecast/frame_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace planecast {
namespace {

constexpr double kExactCloud_m = 2e-6;  // lossless grid clouds: x and y; z is exact
constexpr float kHole = std::numeric_limits<float>::quiet_NaN();

bool finite(const Point3f& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

bool same_bits(const Point3f& a, const Point3f& b) {
  const auto bits = [](float f) { return std::bit_cast<std::uint32_t>(f); };
  return bits(a.x) == bits(b.x) && bits(a.y) == bits(b.y) && bits(a.z) == bits(b.z);
}

double distance(const Point3f& a, const Point3f& b) {
  const double x = double{a.x} - b.x, y = double{a.y} - b.y, z = double{a.z} - b.z;
  return std::sqrt(x * x + y * y + z * z);
}

// The bound of one point under the stream's contract.
class PointBound {
 public:
  explicit PointBound(const StreamSetup& setup)
      : setup_(setup),
        axes_(setup.encoder.stream),
        lossless_(setup.contract.kind == ToleranceKind::kLossless),
        exact_cloud_(lossless_ && setup.cloud_input && setup.grid != nullptr) {}

  // Error over bound: at most 1 when the promise holds.
  double share(const Point3f& original, const Point3f& decoded, double error) const {
    if (same_bits(original, decoded)) return 0;
    if (exact_cloud_ && original.z == decoded.z) return error / kExactCloud_m;
    const double bound = lossless_ ? 0 : setup_.contract.bound_m(axes_.depth(original));
    if (error == 0 && !lossless_) return 0;
    return bound > 0 ? error / bound : std::numeric_limits<double>::infinity();
  }

 private:
  const StreamSetup& setup_;
  OpticalAxes axes_;
  bool lossless_;
  bool exact_cloud_;
};

void check_counts(const OriginalFrame& original, const Decoder& decoder, FrameVerdict& verdict) {
  const auto depth = decoder.depth();
  const auto [a, b] = std::mismatch(original.depth.begin(), original.depth.end(), depth.begin());
  if (a == original.depth.end()) return;
  verdict.identical = false;
  verdict.broken = fmt::format("pixel {} came back as {} instead of {} counts",
                               a - original.depth.begin(), *b, *a);
}

}  // namespace

Result<OriginalFrame> original_of(const StreamSetup& setup, const SensorFrame& frame,
                                  const Decoder& decoder) {
  OriginalFrame out;
  if (setup.encoder.stream.kind == FrameKind::kRawCloud) {
    const auto gated = to_raw_points(setup, frame, out.points);
    if (!gated.ok()) return gated.error();
  } else {
    if (const auto done = to_depth(setup, frame, out.depth); !done.ok()) return done.error();
    const StageOptions& stages = setup.encoder.stages;
    for (std::uint16_t& count : out.depth) {
      if (count < stages.range_min || count > stages.range_max) count = 0;
    }
    if (setup.cloud_input) {
      out.points = frame.cloud.points;
      for (std::size_t i = 0; i < out.points.size(); ++i) {
        if (out.depth[i] == 0) out.points[i] = {kHole, kHole, kHole};
      }
    } else {
      out.points.resize(out.depth.size());
      const StreamTables& tables = decoder.tables();
      const Status status =
          regenerate(tables.config(), tables.rays(), tables.scale(), out.depth, out.points);
      if (status != Status::kOk)
        return Error{status, frame.name + ": the original could not be regenerated"};
    }
  }
  out.readings =
      static_cast<std::uint32_t>(std::count_if(out.points.begin(), out.points.end(), finite));
  return out;
}

FrameVerdict check_frame(const StreamSetup& setup, const OriginalFrame& original,
                         const Decoder& decoder, std::uint32_t may_drop) {
  FrameVerdict verdict;
  const bool lossless = setup.contract.kind == ToleranceKind::kLossless;
  if (lossless && may_drop == 0 && !original.depth.empty())
    check_counts(original, decoder, verdict);
  const PointBound bound(setup);
  const auto decoded = decoder.cloud();
  std::size_t worst = 0;
  for (std::size_t i = 0; i < decoded.size(); ++i) {
    const bool in = finite(original.points[i]), out = finite(decoded[i]);
    verdict.points_out += out ? 1 : 0;
    verdict.lost += in && !out ? 1 : 0;
    verdict.invented += !in && out ? 1 : 0;
    if (!in || !out) continue;
    const double error = distance(original.points[i], decoded[i]);
    const double share = bound.share(original.points[i], decoded[i], error);
    verdict.identical = verdict.identical && same_bits(original.points[i], decoded[i]);
    verdict.max_m = std::max(verdict.max_m, error);
    if (share > verdict.utilisation) worst = i;
    verdict.utilisation = std::max(verdict.utilisation, share);
  }
  verdict.identical = verdict.identical && verdict.lost == 0 && verdict.invented == 0;
  if (!verdict.broken.empty()) return verdict;
  if (verdict.utilisation > 1)
    verdict.broken = fmt::format("point {} is {:.6g} times its bound away from where it was", worst,
                                 verdict.utilisation);
  else if (verdict.invented > 0)
    verdict.broken = fmt::format("{} holes came back as points", verdict.invented);
  else if (verdict.lost != may_drop)
    verdict.broken =
        fmt::format("{} points are missing, but {} were dropped", verdict.lost, may_drop);
  return verdict;
}

}  // namespace planecast
