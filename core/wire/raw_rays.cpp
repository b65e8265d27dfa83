#include "core/wire/raw_rays.hpp"

#include <algorithm>
#include <cmath>

namespace planecast {
namespace {

constexpr int kUnknowns = 8;

// Gaussian elimination with pivoting; the last column is the right-hand side.
bool solve_linear(double (&m)[kUnknowns][kUnknowns + 1]) noexcept {
  for (int i = 0; i < kUnknowns; ++i) {
    int pivot = i;
    for (int r = i + 1; r < kUnknowns; ++r)
      if (std::abs(m[r][i]) > std::abs(m[pivot][i])) pivot = r;
    if (!(std::abs(m[pivot][i]) > 1e-12)) return false;
    for (int c = 0; c <= kUnknowns; ++c) std::swap(m[i][c], m[pivot][c]);
    for (int r = 0; r < kUnknowns; ++r) {
      if (r == i) continue;
      const double factor = m[r][i] / m[i][i];
      for (int c = i; c <= kUnknowns; ++c) m[r][c] -= factor * m[i][c];
    }
  }
  for (auto& row : m) {
    if (!std::isfinite(row[kUnknowns])) return false;
  }
  for (int i = 0; i < kUnknowns; ++i) m[i][kUnknowns] /= m[i][i];
  return true;
}

void round_rays(RawRays& rays) noexcept {
  for (double& value : rays.slope) value = round_to_48(value);
  for (auto& row : rays.ratio)
    for (double& value : row) value = round_to_48(value);
  rays.origin = round_to_48(rays.origin);
  rays.step = round_to_48(rays.step);
}

double coordinate(const Point3f& p, int axis) noexcept {
  return axis == 0 ? p.x : (axis == 1 ? p.y : p.z);
}

// Ratios known to a few parts in 2^24 come from one formula for every pixel.
constexpr double kMostRatioError = 2e-5;
// Numbers of one depth step lie this close together, relatively.
constexpr double kSameDepth = 2e-6;

}  // namespace

void RawRaysFitter::layout(Arena& arena) noexcept {
  samples_ = arena.take<Sample>(kSamples);
  depths_ = arena.take<double>(kSamples);
}

RawRays RawRaysFitter::fit(std::span<const Point3f> points, std::uint32_t width,
                           std::uint32_t height) noexcept {
  RawRays rays;
  const std::size_t count = take_samples(points, width, height, rays);
  if (count < 64) return rays;
  const auto samples = std::span<const Sample>(samples_.first(count));
  const RawRays none = rays;
  const double unit = std::max(width, height);
  if (!solve(samples, unit, 1e30, rays)) return none;
  // Once more without the few that no camera explains.
  const double rms = rms_error(samples, rays);
  if (!solve(samples, unit, 3 * rms + 1e-12, rays)) return none;
  if (!(rms_error(samples, rays) < kMostRatioError)) return none;
  rays.present = true;
  round_rays(rays);
  if (find_steps(samples, DepthSteps::kEven, rays) ||
      find_steps(samples, DepthSteps::kInverse, rays)) {
    round_rays(rays);
  }
  return rays;
}

// Readings spread over the image, and the coordinate that is largest on the whole as primary.
std::size_t RawRaysFitter::take_samples(std::span<const Point3f> points, std::uint32_t width,
                                        std::uint32_t height, RawRays& rays) noexcept {
  std::size_t readings = 0;
  double sums[3] = {};
  for (const Point3f& p : points) {
    if (!is_reading(p)) continue;
    ++readings;
    for (int i = 0; i < 3; ++i) sums[i] += std::abs(coordinate(p, i));
  }
  for (std::uint8_t i = 0; i < 3; ++i)
    if (sums[i] > sums[rays.primary]) rays.primary = i;
  const std::size_t every = (readings / kSamples + 1) | 1U;
  std::size_t seen = 0, count = 0;
  for (std::size_t i = 0; i < points.size() && count < samples_.size(); ++i) {
    if (!is_reading(points[i]) || seen++ % every != 0) continue;
    Sample s;
    s.main = coordinate(points[i], rays.primary);
    if (!(std::abs(s.main) > 1e-20 * sums[rays.primary])) continue;
    s.x = static_cast<double>(i % width) - 0.5 * width;
    s.y = static_cast<double>(i / width) - 0.5 * height;
    for (int k = 0; k < 2; ++k)
      s.ratio[k] = coordinate(points[i], kOtherCoordinates[rays.primary][k]) / s.main;
    samples_[count++] = s;
  }
  return count;
}

// ratio * scale = affine(x, y) is linear in all eight unknowns. `unit` keeps them of one size.
bool RawRaysFitter::solve(std::span<const Sample> samples, double unit, double most_error,
                          RawRays& rays) const noexcept {
  double m[kUnknowns][kUnknowns + 1] = {};
  for (const Sample& s : samples) {
    const double scale = rays.scale(s.x, s.y);
    for (int k = 0; k < 2; ++k) {
      const double r = s.ratio[k];
      const double* known = rays.ratio[k];
      const double error = (known[0] * s.x + known[1] * s.y + known[2]) / scale - r;
      if (!(std::abs(error) <= most_error) || std::abs(r) > 20) continue;
      const double x = s.x / unit, y = s.y / unit;
      double row[kUnknowns] = {};
      row[3 * k] = x;
      row[3 * k + 1] = y;
      row[3 * k + 2] = 1;
      row[6] = -r * x;
      row[7] = -r * y;
      for (int i = 0; i < kUnknowns; ++i) {
        for (int j = 0; j < kUnknowns; ++j) m[i][j] += row[i] * row[j];
        m[i][kUnknowns] += row[i] * r;
      }
    }
  }
  if (!solve_linear(m)) return false;
  for (int k = 0; k < 2; ++k) {
    rays.ratio[k][0] = m[3 * k][kUnknowns] / unit;
    rays.ratio[k][1] = m[3 * k + 1][kUnknowns] / unit;
    rays.ratio[k][2] = m[3 * k + 2][kUnknowns];
    rays.slope[k] = m[6 + k][kUnknowns] / unit;
  }
  return true;
}

// Over the better 95 % or so: each error is cut at ten times the smallest mean yet seen.
double RawRaysFitter::rms_error(std::span<const Sample> samples,
                                const RawRays& rays) const noexcept {
  double sum = 0;
  std::size_t count = 0;
  for (const Sample& s : samples) {
    const double scale = rays.scale(s.x, s.y);
    for (int k = 0; k < 2; ++k) {
      const double* known = rays.ratio[k];
      const double error = (known[0] * s.x + known[1] * s.y + known[2]) / scale - s.ratio[k];
      sum += error * error;
      ++count;
    }
  }
  return std::sqrt(sum / static_cast<double>(count));
}

// Sorted, the depths (or their inverses) of a grid lie in clusters a whole number of steps apart.
bool RawRaysFitter::find_steps(std::span<const Sample> samples, DepthSteps kind,
                               RawRays& rays) noexcept {
  std::size_t count = 0;
  for (const Sample& s : samples) {
    const double depth = s.main / rays.scale(s.x, s.y);
    depths_[count++] = kind == DepthSteps::kInverse ? 1.0 / depth : depth;
  }
  const auto all = depths_.first(count);
  std::sort(all.begin(), all.end());
  // Middle of each cluster, in place.
  std::size_t clusters = 0;
  for (std::size_t i = 0; i < count;) {
    std::size_t end = i + 1;
    while (end < count && all[end] - all[end - 1] < kSameDepth * std::abs(all[end])) ++end;
    all[clusters++] = 0.5 * (all[i] + all[end - 1]);
    i = end;
  }
  if (clusters < 8 || clusters * 4 > count * 3) return false;
  const auto gaps = [&](std::size_t i) { return all[i + 1] - all[i]; };
  double step = gaps(0);
  {
    // The tenth part of the gaps in rising order: one step, for every dense grid. Selection by
    // halving the range of values needs no memory.
    double low = 0, high = all[clusters - 1] - all[0];
    for (int turn = 0; turn < 60; ++turn) {
      const double middle = 0.5 * (low + high);
      std::size_t below = 0;
      for (std::size_t i = 0; i + 1 < clusters; ++i) below += gaps(i) <= middle;
      (below * 10 >= clusters - 1 ? high : low) = middle;
    }
    step = high;
  }
  if (!(step > 0)) return false;
  // Longer and longer spans refine the step; then a line through all clusters.
  double n = 0, sn = 0, ss = 0, snn = 0, sns = 0;
  for (std::size_t i = 0; i < clusters; ++i) {
    if (i > 0) n += std::floor(gaps(i - 1) / step + 0.5);
    if (n > 0 && i > 0) step = (all[i] - all[0]) / n;
    const double offset = all[i] - all[0];
    sn += n;
    ss += offset;
    snn += n * n;
    sns += n * offset;
  }
  const auto k = static_cast<double>(clusters);
  const double spread = k * snn - sn * sn;
  if (!(spread > 0)) return false;
  step = (k * sns - sn * ss) / spread;
  const double origin = all[0] + (ss - step * sn) / k;
  if (!(step > 0) || !std::isfinite(origin)) return false;
  std::size_t on_grid = 0;
  for (const Sample& s : samples) {
    const double depth = s.main / rays.scale(s.x, s.y);
    const double at = ((kind == DepthSteps::kInverse ? 1.0 / depth : depth) - origin) / step;
    on_grid += std::abs(at - std::floor(at + 0.5)) < 0.1;
  }
  if (on_grid * 100 < samples.size() * 97) return false;
  rays.steps = kind;
  rays.origin = origin;
  rays.step = step;
  return true;
}

}  // namespace planecast
