#include "core/fit/point_rounding.hpp"

#include <algorithm>
#include <cmath>

namespace planecast {
namespace {

constexpr double kRoot3 = 1.7320508075688772;
constexpr double kHalfUlp = 0x1p-24;  // of a float, relative
constexpr double kDoubleRoom = 1e-9;  // relative, of the arithmetic here and of the decoder's

// Nearest integer; the argument is far within int64.
std::int64_t nearest(double value) noexcept {
  return static_cast<std::int64_t>(value + (value < 0 ? -0.5 : 0.5));
}

bool finite(const Point3f& p) noexcept {
  return p.x - p.x == 0 && p.y - p.y == 0 && p.z - p.z == 0;
}

struct Rounding {
  double step_m = 0;
  double per_step = 0;
  double reach_m = 0;  // largest coordinate met
  bool exact = false;
  bool fits = true;

  std::int32_t take(float value) noexcept {
    if (step_m == 0) return rank_of_float(value);
    const double size = std::abs(double{value});
    reach_m = std::max(reach_m, size);
    const double steps = value * per_step;
    if (!(std::abs(steps) <= kMaxGridCoordinate)) {
      fits = false;
      return 0;
    }
    const auto out = static_cast<std::int32_t>(nearest(steps));
    // Bits, not values: -0 is not 0.
    if (exact && rank_of_float(grid_metres(out, step_m)) != rank_of_float(value)) fits = false;
    return out;
  }
};

}  // namespace

double tolerance_steps(double bound_m, double step_m, double reach_m) noexcept {
  const double grid = 0.5 * kRoot3 * step_m;
  const double output = kRoot3 * kHalfUlp * (reach_m + bound_m);
  return (bound_m * (1 - kDoubleRoom) - grid - output) / step_m;
}

Status round_points(const StreamConfig& config, std::span<const Point3f> points,
                    std::span<const std::uint8_t> fates, std::span<GridPoint> out,
                    std::uint32_t& count) noexcept {
  count = 0;
  if (points.size() != fates.size()) return Status::kWrongSize;
  Rounding rounding;
  rounding.step_m = grid_step_m(config.points);
  rounding.per_step = rounding.step_m == 0 ? 0 : 1 / rounding.step_m;
  rounding.exact = config.tolerance == ToleranceKind::kLossless;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (fates[i] != 0) continue;
    const Point3f& p = points[i];
    if (count == out.size()) return Status::kWrongSize;
    if (!finite(p)) return Status::kBoundExceeded;
    out[count++] = {rounding.take(p.x), rounding.take(p.y), rounding.take(p.z)};
  }
  if (!rounding.fits) return Status::kBoundExceeded;
  if (rounding.exact) return Status::kOk;
  const double bound_m = static_cast<double>(point_bound_pm(config)) * 1e-12;
  const double most = tolerance_steps(bound_m, rounding.step_m, rounding.reach_m);
  return config.points.tolerance_steps <= most ? Status::kOk : Status::kBoundExceeded;
}

}  // namespace planecast
