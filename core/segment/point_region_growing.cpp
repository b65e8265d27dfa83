#include "core/segment/point_region_growing.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace planecast {
namespace {

constexpr std::uint32_t kFresh = kNoRegion;        // not reached yet
constexpr std::uint32_t kGivenUp = kNoRegion - 1;  // in a region too small to keep

bool has_normal(const PointNormals& normals, std::uint32_t i) noexcept {
  return normals.curvature[i] < kNoCurvature;
}

bool in_range(const PointRegionOptions& o) noexcept {
  return o.smoothness_deg >= 0 && o.smoothness_deg <= 90 && o.curvature_limit >= 0;
}

/// Mean distances of neighbours within regions and across their borders.
void measure_segments(const PointNeighbours& cloud, std::span<const std::uint32_t> regions,
                      PointRegionReport& report) noexcept {
  double sum[2] = {};
  std::uint64_t pairs[2] = {};
  const std::span<const float> x = cloud.x(), y = cloud.y(), z = cloud.z();
  for (std::uint32_t i = 0; i < cloud.size(); ++i) {
    if (regions[i] == kNoRegion) continue;
    for (const std::uint32_t m : cloud.of(i)) {
      if (regions[m] == kNoRegion) continue;
      const float dx = x[m] - x[i], dy = y[m] - y[i], dz = z[m] - z[i];
      const int across = regions[m] != regions[i] ? 1 : 0;
      sum[across] += std::sqrt(dx * dx + dy * dy + dz * dz);
      ++pairs[across];
    }
  }
  report.intra_distance = pairs[0] > 0 ? sum[0] / static_cast<double>(pairs[0]) : 0;
  report.inter_distance = pairs[1] > 0 ? sum[1] / static_cast<double>(pairs[1]) : 0;
}

}  // namespace

void PointRegionGrowing::layout(Arena& arena, std::uint32_t max_points) noexcept {
  seeds_ = arena.take<std::uint32_t>(max_points);
  queue_ = arena.take<std::uint32_t>(max_points);
}

// Two passes of a radix sort over 16 bits of the curvature, 0..1/3 and 1 for none: steps of 1e-5.
void PointRegionGrowing::sort_by_curvature(std::span<const float> curvature) noexcept {
  const auto n = static_cast<std::uint32_t>(curvature.size());
  const auto key = [&](std::uint32_t i) {
    return std::min(65535U, static_cast<std::uint32_t>(curvature[i] * 65536.0F * 3.0F));
  };
  for (int pass = 0; pass < 2; ++pass) {
    std::array<std::uint32_t, 257> start{};
    const unsigned shift = pass == 0 ? 0 : 8;
    for (std::uint32_t i = 0; i < n; ++i) ++start[((key(i) >> shift) & 0xffU) + 1];
    for (std::size_t b = 1; b < start.size(); ++b) start[b] += start[b - 1];
    for (std::uint32_t i = 0; i < n; ++i) {
      const std::uint32_t point = pass == 0 ? i : queue_[i];
      (pass == 0 ? queue_ : seeds_)[start[(key(point) >> shift) & 0xffU]++] = point;
    }
  }
}

Status PointRegionGrowing::grow(const PointNeighbours& cloud, const PointNormals& normals,
                                const PointRegionOptions& options, std::span<std::uint32_t> regions,
                                PointRegionReport& report) noexcept {
  report = {};
  const std::uint32_t n = cloud.size();
  if (regions.size() != n || normals.x.size() != n || normals.y.size() != n ||
      normals.z.size() != n || normals.curvature.size() != n) {
    return Status::kWrongSize;
  }
  if (n > seeds_.size()) return Status::kFrameTooLarge;
  if (!in_range(options)) return Status::kBadConfig;
  const auto least_cosine =
      static_cast<float>(std::cos(options.smoothness_deg * std::numbers::pi / 180));
  const auto limit = static_cast<float>(options.curvature_limit);
  const bool difference = options.test == CurvatureTest::kDifference;
  const std::span<const float> nx = normals.x, ny = normals.y, nz = normals.z;
  const std::span<const float> curvature = normals.curvature;
  std::fill(regions.begin(), regions.end(), kFresh);
  sort_by_curvature(curvature);

  for (const std::uint32_t start : seeds_.first(n)) {
    if (regions[start] != kFresh || !has_normal(normals, start)) continue;
    // The queue holds the region's points, seeds in front of those that do not go on: a seed that
    // is found is swapped to the end of the seeds.
    std::uint32_t points = 0, seeds = 0;
    queue_[points++] = start;
    seeds = 1;
    regions[start] = report.regions;
    for (std::uint32_t s = 0; s < seeds; ++s) {
      const std::uint32_t seed = queue_[s];
      for (const std::uint32_t m : cloud.of(seed)) {
        if (regions[m] != kFresh || !has_normal(normals, m)) continue;
        const float cosine = nx[seed] * nx[m] + ny[seed] * ny[m] + nz[seed] * nz[m];
        if (std::abs(cosine) < least_cosine) continue;
        regions[m] = report.regions;
        queue_[points++] = m;
        const float test = difference ? std::abs(curvature[m] - curvature[seed]) : curvature[m];
        if (test <= limit) std::swap(queue_[seeds++], queue_[points - 1]);
      }
    }
    ++report.clusters;
    if (points < options.min_points) {
      for (const std::uint32_t m : queue_.first(points)) regions[m] = kGivenUp;
    } else {
      ++report.regions;
      report.points += points;
    }
  }
  std::replace(regions.begin(), regions.end(), kGivenUp, kNoRegion);
  measure_segments(cloud, regions, report);
  return Status::kOk;
}

}  // namespace planecast
