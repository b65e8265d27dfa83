#include "core/fit/point_planes.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/lanes.hpp"
#include "core/model/least_eigen.hpp"

namespace planecast {
namespace {

bool in_range(const PointPlaneOptions& o) noexcept {
  return o.distance_m > 0 && std::isfinite(o.distance_m) && o.iterations >= 1 &&
         o.confidence >= 0 && o.confidence < 1 && o.min_points >= 3 && o.min_share >= 0;
}

/// A plane with coordinates relative to a point of the region: small numbers, in float.
struct LocalPlane {
  float a = 0, b = 0, c = 0, d = 0;
};

}  // namespace

/// The points of a region that no plane has taken yet, relative to `origin`; padded by infinities
/// to whole groups of four.
struct PointPlaneFitter::Rest {
  float *x, *y, *z;
  std::uint32_t* place;
  std::uint32_t count = 0;
  double origin[3] = {};

  void pad() noexcept {
    for (std::uint32_t i = count; i < ((count + 3) & ~3U); ++i)
      x[i] = y[i] = z[i] = std::numeric_limits<float>::infinity();
  }

  std::uint32_t inliers(const LocalPlane& p, float distance) const noexcept {
    Int4 sum = {0, 0, 0, 0};
    for (std::uint32_t i = 0; i < count; i += 4) {
      const Float4 h = load4(x + i) * all4(p.a) + load4(y + i) * all4(p.b) +
                       load4(z + i) * all4(p.c) + all4(p.d);
      sum -= abs4(h) <= all4(distance);
    }
    return static_cast<std::uint32_t>(sum[0] + sum[1] + sum[2] + sum[3]);
  }

  float height(const LocalPlane& p, std::uint32_t i) const noexcept {
    return x[i] * p.a + y[i] * p.b + z[i] * p.c + p.d;
  }

  /// Plane through three points; false when they lie on a line.
  bool through(std::uint32_t i, std::uint32_t j, std::uint32_t k, LocalPlane& p) const noexcept {
    const float ux = x[j] - x[i], uy = y[j] - y[i], uz = z[j] - z[i];
    const float vx = x[k] - x[i], vy = y[k] - y[i], vz = z[k] - z[i];
    const float a = uy * vz - uz * vy, b = uz * vx - ux * vz, c = ux * vy - uy * vx;
    const float length = std::sqrt(a * a + b * b + c * c);
    const float sides = (ux * ux + uy * uy + uz * uz) * (vx * vx + vy * vy + vz * vz);
    if (!(length * length > 1e-8F * sides)) return false;
    p = {a / length, b / length, c / length, 0};
    p.d = -(p.a * x[i] + p.b * y[i] + p.c * z[i]);
    return true;
  }

  /// Least squares through the points within `distance` of `p`; false when they are all equal.
  bool refine(LocalPlane& p, float distance) const noexcept {
    double s[3] = {}, q[6] = {}, n = 0;
    for (std::uint32_t i = 0; i < count; ++i) {
      if (!(std::abs(height(p, i)) <= distance)) continue;
      const double dx = x[i], dy = y[i], dz = z[i];
      n += 1;
      s[0] += dx;
      s[1] += dy;
      s[2] += dz;
      q[0] += dx * dx;
      q[1] += dx * dy;
      q[2] += dx * dz;
      q[3] += dy * dy;
      q[4] += dy * dz;
      q[5] += dz * dz;
    }
    if (n < 3) return false;
    const double mx = s[0] / n, my = s[1] / n, mz = s[2] / n;
    const Symmetric3 m = {q[0] / n - mx * mx, q[1] / n - mx * my, q[2] / n - mx * mz,
                          q[3] / n - my * my, q[4] / n - my * mz, q[5] / n - mz * mz};
    LeastEigen least;
    if (!least_eigen(m, least)) return false;
    p = {static_cast<float>(least.x), static_cast<float>(least.y), static_cast<float>(least.z),
         static_cast<float>(-(least.x * mx + least.y * my + least.z * mz))};
    return true;
  }
};

void PointPlaneFitter::layout(Arena& arena, std::uint32_t max_points) noexcept {
  x_ = arena.take<float>(std::size_t{max_points} + 4);
  y_ = arena.take<float>(std::size_t{max_points} + 4);
  z_ = arena.take<float>(std::size_t{max_points} + 4);
  place_ = arena.take<std::uint32_t>(max_points);
  by_region_ = arena.take<std::uint32_t>(max_points);
  region_end_ = arena.take<std::uint32_t>(std::size_t{max_points} + 1);
}

/// Best of the samples, made better by least squares. False when none holds min_points.
bool PointPlaneFitter::find_plane(Rest& rest, const PointPlaneOptions& options, Pcg32& random,
                                  PointPlane& plane) noexcept {
  const auto distance = static_cast<float>(options.distance_m);
  rest.pad();
  LocalPlane best;
  std::uint32_t most = 0;
  double needed = options.iterations;
  for (std::uint32_t round = 0; round < needed; ++round) {
    const std::uint32_t i = random.below(rest.count), j = random.below(rest.count),
                        k = random.below(rest.count);
    LocalPlane trial;
    if (!rest.through(i, j, k, trial)) continue;
    const std::uint32_t inliers = rest.inliers(trial, distance);
    if (inliers <= most) continue;
    most = inliers;
    best = trial;
    const double good = std::pow(static_cast<double>(inliers) / rest.count, 3);
    if (good >= 1) break;
    const double rounds = std::log(1 - options.confidence) / std::log(1 - good);
    needed = std::min<double>(options.iterations, rounds);
  }
  if (most < 3) return false;
  for (int round = 0; round < 2; ++round) {
    LocalPlane better = best;
    if (!rest.refine(better, distance)) break;
    const std::uint32_t inliers = rest.inliers(better, distance);
    if (inliers < most) break;
    most = inliers;
    best = better;
  }
  if (most < options.min_points) return false;
  plane.a = best.a;
  plane.b = best.b;
  plane.c = best.c;
  plane.d =
      best.d - (plane.a * rest.origin[0] + plane.b * rest.origin[1] + plane.c * rest.origin[2]);
  plane.count = most;
  return true;
}

Status PointPlaneFitter::fit(const PointColumns& points, std::span<const std::uint32_t> regions,
                             std::uint32_t region_count, const PointPlaneOptions& options,
                             std::span<PointPlane> planes, std::uint32_t& plane_count,
                             std::span<std::uint32_t> members,
                             std::uint32_t& member_count) noexcept {
  plane_count = member_count = 0;
  const std::size_t n = regions.size();
  if (points.x.size() != n || points.y.size() != n || points.z.size() != n || members.size() < n)
    return Status::kWrongSize;
  if (n > by_region_.size() || region_count > by_region_.size()) return Status::kFrameTooLarge;
  if (!in_range(options)) return Status::kBadConfig;
  sort_by_region(regions, region_count);
  Pcg32 random(options.seed);
  for (std::uint32_t r = 0; r < region_count; ++r) {
    const std::uint32_t begin = r == 0 ? 0 : region_end_[r - 1], end = region_end_[r];
    if (end - begin < options.min_points) continue;
    Rest rest{x_.data(), y_.data(), z_.data(), place_.data()};
    const std::uint32_t first = by_region_[begin];
    rest.origin[0] = points.x[first];
    rest.origin[1] = points.y[first];
    rest.origin[2] = points.z[first];
    for (std::uint32_t m = begin; m < end; ++m) {
      const std::uint32_t place = by_region_[m];
      rest.x[rest.count] = points.x[place] - points.x[first];
      rest.y[rest.count] = points.y[place] - points.y[first];
      rest.z[rest.count] = points.z[place] - points.z[first];
      rest.place[rest.count++] = place;
    }
    const double least = std::max<double>(options.min_points, options.min_share * (end - begin));
    while (rest.count >= least) {
      PointPlane plane;
      if (!find_plane(rest, options, random, plane)) break;
      if (plane_count == planes.size()) return Status::kTooLarge;
      plane.region = r;
      take_members(rest, options.distance_m, plane, members, member_count);
      planes[plane_count++] = plane;
    }
  }
  return Status::kOk;
}

void PointPlaneFitter::sort_by_region(std::span<const std::uint32_t> regions,
                                      std::uint32_t region_count) noexcept {
  std::span<std::uint32_t> next = region_end_.first(region_count + std::size_t{1});
  std::fill(next.begin(), next.end(), 0U);
  for (const std::uint32_t region : regions) {
    if (region < region_count) ++next[region + 1];
  }
  for (std::uint32_t r = 0; r < region_count; ++r) next[r + 1] += next[r];
  for (std::uint32_t i = 0; i < regions.size(); ++i) {
    if (regions[i] < region_count) by_region_[next[regions[i]]++] = i;
  }
}

/// Moves the plane's points from the rest to the members.
void PointPlaneFitter::take_members(Rest& rest, double distance_m, PointPlane& plane,
                                    std::span<std::uint32_t> members,
                                    std::uint32_t& member_count) noexcept {
  const auto distance = static_cast<float>(distance_m);
  const LocalPlane local = {
      static_cast<float>(plane.a), static_cast<float>(plane.b), static_cast<float>(plane.c),
      static_cast<float>(plane.d + (plane.a * rest.origin[0] + plane.b * rest.origin[1] +
                                    plane.c * rest.origin[2]))};
  plane.first = member_count;
  std::uint32_t left = 0;
  for (std::uint32_t i = 0; i < rest.count; ++i) {
    if (std::abs(rest.height(local, i)) <= distance) {
      members[member_count++] = rest.place[i];
      continue;
    }
    rest.x[left] = rest.x[i];
    rest.y[left] = rest.y[i];
    rest.z[left] = rest.z[i];
    rest.place[left++] = rest.place[i];
  }
  plane.count = member_count - plane.first;
  rest.count = left;
}

}  // namespace planecast
