#include "core/segment/voxel_regions.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "core/model/least_eigen.hpp"

namespace planecast {
namespace {

constexpr std::uint32_t kNone = kNoRegion;
constexpr std::uint32_t kGivenUp = kNoRegion - 1;
constexpr std::int32_t kMostVoxel = 1 << 20;

bool usable(const Point3f& p, float reach) noexcept {
  return std::abs(p.x) <= reach && std::abs(p.y) <= reach && std::abs(p.z) <= reach;
}

bool in_range(const VoxelRegionOptions& o) noexcept {
  return o.voxel_m > 0 && o.points_per_voxel >= 0 && o.smoothness_deg >= 0 &&
         o.smoothness_deg <= 90 && o.roughness >= 0 && o.distance_share > 0;
}

}  // namespace

void VoxelRegions::layout(Arena& arena, std::uint32_t max_points) noexcept {
  table_ = arena.take<std::uint32_t>(std::bit_ceil(std::size_t{max_points} * 2 + 2));
  voxels_ = arena.take<Voxel>(max_points);
  voxel_of_ = arena.take<std::uint32_t>(max_points);
  order_ = arena.take<std::uint32_t>(max_points);
  queue_ = arena.take<std::uint32_t>(max_points);
  x_ = arena.take<float>(max_points);
  y_ = arena.take<float>(max_points);
  z_ = arena.take<float>(max_points);
  source_ = arena.take<std::uint32_t>(max_points);
  regions_ = arena.take<std::uint32_t>(max_points);
}

/// The slot of a voxel, or the free one where it would go. Never full: twice as many as points.
std::uint32_t VoxelRegions::slot_of(std::int32_t i, std::int32_t j, std::int32_t k) const noexcept {
  const auto mask = static_cast<std::uint32_t>(std::bit_ceil(std::size_t{size_} * 2 + 2) - 1);
  std::uint64_t h = static_cast<std::uint32_t>(i) * 0x9e3779b97f4a7c15ULL;
  h = (h ^ static_cast<std::uint32_t>(j)) * 0xbf58476d1ce4e5b9ULL;
  h = (h ^ static_cast<std::uint32_t>(k)) * 0x94d049bb133111ebULL;
  auto slot = static_cast<std::uint32_t>(h >> 32U) & mask;
  for (;; slot = (slot + 1) & mask) {
    const std::uint32_t entry = table_[slot];
    if (entry == 0) return slot;
    const Voxel& v = voxels_[entry - 1];
    if (v.i == i && v.j == j && v.k == k) return slot;
  }
}

std::uint32_t VoxelRegions::voxel_at(std::int32_t i, std::int32_t j,
                                     std::int32_t k) const noexcept {
  const std::uint32_t entry = table_[slot_of(i, j, k)];
  return entry == 0 ? kNone : entry - 1;
}

/// Voxels of all points at the present side, with their sums.
void VoxelRegions::fill_voxels(std::span<const Point3f> points, float reach) noexcept {
  std::fill_n(table_.begin(), std::bit_ceil(std::size_t{size_} * 2 + 2), 0U);
  voxel_count_ = 0;
  const double scale = 1 / voxel_m_;
  std::uint32_t last = kNone;  // points that follow each other often share a voxel
  for (std::uint32_t n = 0; n < points.size(); ++n) {
    const Point3f& p = points[n];
    voxel_of_[n] = kNone;
    if (!usable(p, reach)) continue;
    const double fx = std::floor(p.x * scale), fy = std::floor(p.y * scale),
                 fz = std::floor(p.z * scale);
    const auto i = static_cast<std::int32_t>(fx), j = static_cast<std::int32_t>(fy),
               k = static_cast<std::int32_t>(fz);
    if (last == kNone || voxels_[last].i != i || voxels_[last].j != j || voxels_[last].k != k) {
      const std::uint32_t slot = slot_of(i, j, k);
      if (table_[slot] == 0) {
        voxels_[voxel_count_] = {};
        voxels_[voxel_count_].i = i;
        voxels_[voxel_count_].j = j;
        voxels_[voxel_count_].k = k;
        voxels_[voxel_count_].region = kNone;
        table_[slot] = ++voxel_count_;
      }
      last = table_[slot] - 1;
    }
    Voxel& v = voxels_[last];
    voxel_of_[n] = last;
    ++v.count;
    const auto x = static_cast<float>(p.x * scale - fx - 0.5),
               y = static_cast<float>(p.y * scale - fy - 0.5),
               z = static_cast<float>(p.z * scale - fz - 0.5);
    Sums& s = v.sums;
    s.n += 1;
    s.x += x;
    s.y += y;
    s.z += z;
    s.xx += x * x;
    s.xy += x * y;
    s.xz += x * z;
    s.yy += y * y;
    s.yz += y * z;
    s.zz += z * z;
  }
}

void VoxelRegions::sort_points(std::span<const Point3f> points, float reach) noexcept {
  std::uint32_t first = 0;
  for (Voxel& v : voxels_.first(voxel_count_)) {
    v.first = first;
    first += v.count;
    v.count = 0;
  }
  for (std::uint32_t n = 0; n < points.size(); ++n) {
    if (!usable(points[n], reach)) continue;
    Voxel& v = voxels_[voxel_of_[n]];
    const std::uint32_t place = v.first + v.count++;
    x_[place] = points[n].x;
    y_[place] = points[n].y;
    z_[place] = points[n].z;
    source_[place] = n;
  }
}

/// Sums of points relative to a common zero, in double.
struct VoxelRegions::Plane {
  double n = 0, x = 0, y = 0, z = 0, xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;

  /// Adds sums whose own zero lies at (a, b, c).
  void add(const Sums& s, double a, double b, double c) noexcept {
    n += s.n;
    x += s.x + a * s.n;
    y += s.y + b * s.n;
    z += s.z + c * s.n;
    xx += s.xx + 2 * a * s.x + a * a * s.n;
    xy += s.xy + a * s.y + b * s.x + a * b * s.n;
    xz += s.xz + a * s.z + c * s.x + a * c * s.n;
    yy += s.yy + 2 * b * s.y + b * b * s.n;
    yz += s.yz + b * s.z + c * s.y + b * c * s.n;
    zz += s.zz + 2 * c * s.z + c * c * s.n;
  }

  bool normal(LeastEigen& least) const noexcept {
    if (n < 3) return false;
    const double r = 1 / n, mx = x * r, my = y * r, mz = z * r;
    return least_eigen({xx * r - mx * mx, xy * r - mx * my, xz * r - mx * mz, yy * r - my * my,
                        yz * r - my * mz, zz * r - mz * mz},
                       least);
  }
};

void VoxelRegions::measure_voxels() noexcept {
  for (Voxel& v : voxels_.first(voxel_count_)) {
    Plane plane;
    for (std::int32_t dk = -1; dk <= 1; ++dk) {
      for (std::int32_t dj = -1; dj <= 1; ++dj) {
        for (std::int32_t di = -1; di <= 1; ++di) {
          const bool self = di == 0 && dj == 0 && dk == 0;
          const std::uint32_t m = self ? 0 : voxel_at(v.i + di, v.j + dj, v.k + dk);
          if (m != kNone) plane.add(self ? v.sums : voxels_[m].sums, di, dj, dk);
        }
      }
    }
    LeastEigen least;
    v.curvature = kNoCurvature;
    if (!plane.normal(least)) continue;
    v.curvature = static_cast<float>(least.share);
    v.normal[0] = static_cast<float>(least.x);
    v.normal[1] = static_cast<float>(least.y);
    v.normal[2] = static_cast<float>(least.z);
  }
}

/// Grows a region over voxels whose normals agree with the region's and whose means lie on its
/// plane; the plane is fitted anew whenever the region has doubled. Returns its points.
std::uint32_t VoxelRegions::grow(std::uint32_t seed, const VoxelRegionOptions& options,
                                 std::uint32_t region) noexcept {
  const double cosine = std::cos(options.smoothness_deg * std::numbers::pi / 180);
  const Voxel& origin = voxels_[seed];
  Plane sums;
  double normal[3] = {origin.normal[0], origin.normal[1], origin.normal[2]};
  std::uint32_t points = 0, size = 0, refit = 8;
  queue_[size++] = seed;
  voxels_[seed].region = region;
  for (std::uint32_t s = 0; s < size; ++s) {
    const Voxel& v = voxels_[queue_[s]];
    sums.add(v.sums, v.i - origin.i, v.j - origin.j, v.k - origin.k);
    points += v.count;
    if (s + 1 == refit) {
      LeastEigen least;
      if (sums.normal(least)) {
        normal[0] = least.x;
        normal[1] = least.y;
        normal[2] = least.z;
      }
      refit *= 2;
    }
    const double mean[3] = {sums.x / sums.n, sums.y / sums.n, sums.z / sums.n};
    for (std::uint32_t d = 0; d < 27; ++d) {
      const std::uint32_t m = voxel_at(v.i + static_cast<std::int32_t>(d % 3) - 1,
                                       v.j + static_cast<std::int32_t>(d / 3 % 3) - 1,
                                       v.k + static_cast<std::int32_t>(d / 9) - 1);
      if (m == kNone || voxels_[m].region != kNone) continue;
      Voxel& w = voxels_[m];
      if (!(w.curvature <= options.roughness)) continue;
      const double dot =
          normal[0] * w.normal[0] + normal[1] * w.normal[1] + normal[2] * w.normal[2];
      if (std::abs(dot) < cosine) continue;
      const double height = normal[0] * (w.i - origin.i + double{w.sums.x} / w.sums.n - mean[0]) +
                            normal[1] * (w.j - origin.j + double{w.sums.y} / w.sums.n - mean[1]) +
                            normal[2] * (w.k - origin.k + double{w.sums.z} / w.sums.n - mean[2]);
      if (std::abs(height) > options.distance_share) continue;
      w.region = region;
      queue_[size++] = m;
    }
  }
  if (points >= options.min_points) return points;
  for (const std::uint32_t m : queue_.first(size)) voxels_[m].region = kGivenUp;
  return 0;
}

Status VoxelRegions::find(std::span<const Point3f> points, float reach,
                          const VoxelRegionOptions& options, PointRegionReport& report) noexcept {
  report = {};
  size_ = voxel_count_ = 0;
  if (!in_range(options) || !(reach > 0) || !(reach < 1e30F)) return Status::kBadConfig;
  if (points.size() > voxel_of_.size()) return Status::kFrameTooLarge;
  float farthest = 0;
  for (const Point3f& p : points) {
    if (!usable(p, reach)) continue;
    ++size_;
    farthest = std::max({farthest, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
  }
  if (size_ == 0) return Status::kOk;
  voxel_m_ = options.voxel_m;
  while (farthest / voxel_m_ > kMostVoxel) voxel_m_ *= 2;  // their numbers fit 32 bits with ease
  for (int round = 0;; ++round) {
    fill_voxels(points, reach);
    if (round == 12 || options.points_per_voxel * voxel_count_ <= size_) break;
    voxel_m_ *= 2;
  }
  sort_points(points, reach);
  measure_voxels();
  for (std::uint32_t v = 0; v < voxel_count_; ++v) order_[v] = v;
  std::sort(order_.begin(), order_.begin() + voxel_count_, [&](std::uint32_t a, std::uint32_t b) {
    const float ca = voxels_[a].curvature, cb = voxels_[b].curvature;
    return ca != cb ? ca < cb : a < b;
  });
  for (const std::uint32_t seed : order_.first(voxel_count_)) {
    if (voxels_[seed].region != kNone || !(voxels_[seed].curvature <= options.roughness)) continue;
    ++report.clusters;
    const std::uint32_t grown = grow(seed, options, report.regions);
    report.points += grown;
    report.regions += grown > 0 ? 1 : 0;
  }
  for (const Voxel& v : voxels_.first(voxel_count_)) {
    const std::uint32_t region = v.region == kGivenUp ? kNoRegion : v.region;
    std::fill_n(&regions_[v.first], v.count, region);
  }
  return Status::kOk;
}

}  // namespace planecast
