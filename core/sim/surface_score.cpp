#include "core/sim/surface_score.hpp"

#include <algorithm>
#include <cmath>

namespace planecast {
namespace {

constexpr double kDegrees = 180.0 / 3.14159265358979323846;
constexpr double kSamePlane = 1e-6;

Vec3 unit(const Vec3& v) noexcept {
  return (1 / std::sqrt(dot(v, v))) * v;
}

double angle_deg(const Vec3& a, const Vec3& b) noexcept {
  return kDegrees * std::acos(std::min(1.0, std::abs(dot(a, b))));
}

bool one_plane(const TruthSurface& a, const TruthSurface& b) noexcept {
  return a.kind == TruthSurface::Kind::kPlane && b.kind == TruthSurface::Kind::kPlane &&
         dot(a.normal - b.normal, a.normal - b.normal) < kSamePlane * kSamePlane &&
         std::abs(a.distance - b.distance) < kSamePlane;
}

// For each id the first id that lies in the same plane.
std::vector<std::uint16_t> canonical_ids(std::span<const TruthSurface> truth) {
  std::vector<std::uint16_t> out(truth.size() + 1);
  for (std::size_t i = 0; i < truth.size(); ++i) {
    std::size_t first = 0;
    while (first < i && !one_plane(truth[first], truth[i])) ++first;
    out[i + 1] = static_cast<std::uint16_t>(first + 1);
  }
  return out;
}

// Width of a surface, or height where that is less, as the mean run of its pixels [px].
std::vector<double> widths(const RayTable& rays, std::span<const std::uint16_t> ids,
                           std::size_t surfaces) {
  std::vector<std::uint32_t> pixels(surfaces + 1), across(surfaces + 1), down(surfaces + 1);
  for (std::uint32_t v = 0; v < rays.height; ++v) {
    for (std::uint32_t u = 0; u < rays.width; ++u) {
      const std::size_t i = std::size_t{v} * rays.width + u;
      ++pixels[ids[i]];
      across[ids[i]] += u == 0 || ids[i - 1] != ids[i];
      down[ids[i]] += v == 0 || ids[i - rays.width] != ids[i];
    }
  }
  std::vector<double> out(surfaces + 1);
  for (std::size_t t = 0; t <= surfaces; ++t) {
    if (pixels[t] > 0) out[t] = static_cast<double>(pixels[t]) / std::max(across[t], down[t]);
  }
  return out;
}

}  // namespace

// The surface is z P(x, y) = 1 with x = X / z, y = Y / z: its gradient is (Px, Py, P - x Px - y
// Py).
Vec3 found_normal(const FoundSurface& s, double x, double y) noexcept {
  const double px = s.a + 2 * s.d * x + s.e * y, py = s.b + s.e * x + 2 * s.f * y;
  const double p = s.c + x * (s.a + s.d * x + s.e * y) + y * (s.b + s.f * y);
  return unit({px, py, p - x * px - y * py});
}

SurfaceScore score_surfaces(const RayTable& rays, std::span<const std::uint16_t> truth_ids,
                            std::span<const TruthSurface> truth,
                            std::span<const std::uint8_t> labels,
                            std::span<const FoundSurface> found, const ScoreOptions& options) {
  const std::vector<std::uint16_t> canonical = canonical_ids(truth);
  const std::vector<double> width = widths(rays, truth_ids, truth.size());
  // Pixels of each true surface, each found one, and each pair.
  const std::size_t stride = found.size() + 1;
  std::vector<std::uint32_t> of_truth(truth.size() + 1), of_found(stride);
  std::vector<std::uint32_t> common((truth.size() + 1) * stride);
  for (std::size_t i = 0; i < truth_ids.size(); ++i) {
    const std::uint16_t id = canonical[truth_ids[i]];
    if (id == 0) continue;  // only what is visible counts
    ++of_truth[id];
    ++of_found[labels[i]];
    ++common[id * stride + labels[i]];
  }
  std::vector<double> widest(truth.size() + 1);
  for (std::size_t t = 1; t <= truth.size(); ++t) {
    widest[canonical[t]] = std::max(widest[canonical[t]], width[t]);
  }
  const auto counts = [&](std::size_t t) {
    return truth[t - 1].kind == TruthSurface::Kind::kPlane && of_truth[t] >= options.min_pixels &&
           widest[t] >= options.min_width;
  };
  SurfaceScore score;
  score.truth_of.resize(found.size());
  std::vector<std::uint32_t> elsewhere(stride);
  for (std::size_t t = 1; t <= truth.size(); ++t) {
    score.truth += counts(t);
    for (std::size_t f = 1; f < stride; ++f) {
      const double both = common[t * stride + f];
      if (!counts(t)) {
        elsewhere[f] += common[t * stride + f];
      } else if (of_found[f] >= options.min_pixels && both >= options.overlap * of_truth[t] &&
                 both >= options.overlap * of_found[f] &&
                 angle_deg(truth[t - 1].normal, found_normal(found[f - 1], 0, 0)) <=
                     options.max_angle_deg) {
        ++score.matched;
        score.truth_of[f - 1] = static_cast<std::uint16_t>(t);
      }
    }
  }
  for (std::size_t f = 1; f < stride; ++f) {
    score.found += of_found[f] >= options.min_pixels && 2 * elsewhere[f] < of_found[f];
  }
  return score;
}

}  // namespace planecast
