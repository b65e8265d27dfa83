#include "core/fit/plane_fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace planecast {
namespace {

constexpr float kInlier = 4.0F;        // noise variances: more is no noise of this surface
constexpr std::uint32_t kInside = 4;   // cells inside a region that make a fit of their own
constexpr std::uint32_t kReach = 2;    // fine cells that noise is shared over
constexpr double kInsideShare = 0.25;  // of the region's cells

// A region's sums over all of its cells, or only those inside it.
struct Sums {
  PlaneSums plane;
  QuadricSums quadric;
  double readings = 0;
  std::uint32_t cells = 0;

  void add(const Cell& cell, bool curved) noexcept {
    plane.add(plane_sums(cell));
    if (curved) add_cell(quadric, cell);
    readings += double{cell.n};
    ++cells;
  }
  bool solve(bool curved, FloatSurface& out, double& residual) const noexcept {
    double mean_square = 0;
    if (curved && quadric.solve(out, mean_square)) {
      residual = mean_square * quadric.n / readings;
      return true;
    }
    if (!plane.solve(out)) return false;
    residual = plane.mean_square(out) * plane.n / readings;
    return true;
  }
};

bool is_curved(const RegionMap& regions, unsigned label) noexcept {
  return ((regions.curved >> label) & 1U) != 0;
}

// Four neighbours of the same region, those beyond the image included.
bool is_inside(const RegionMap& regions, std::uint32_t x, std::uint32_t y) noexcept {
  const std::size_t i = std::size_t{y} * regions.cells_wide + x;
  const std::uint8_t label = regions.labels[i];
  return (x == 0 || regions.labels[i - 1] == label) &&
         (x + 1 == regions.cells_wide || regions.labels[i + 1] == label) &&
         (y == 0 || regions.labels[i - regions.cells_wide] == label) &&
         (y + 1 == regions.cells_high || regions.labels[i + regions.cells_wide] == label);
}

// Calls f(cell, label) for every labelled cell with readings.
template <class F>
void for_each_cell(const RegionMap& regions, F&& f) noexcept {
  for (std::size_t i = 0; i < regions.labels.size(); ++i) {
    if (regions.labels[i] != 0 && regions.cells[i].n != 0) f(regions.cells[i], regions.labels[i]);
  }
}

bool is_inlier(const Cell& cell, const FloatSurface& surface) noexcept {
  return cell_residual(cell, surface) <= kInlier;
}

}  // namespace

void fit_regions(const RegionMap& regions, std::span<RegionFit> fits,
                 std::uint64_t wanted) noexcept {
  std::array<Sums, kMaxSurfaces + 1> all{};
  std::array<float, kMaxSurfaces + 1> least{};
  for_each_cell(regions, [&](const Cell& cell, std::uint8_t label) {
    if (((wanted >> label) & 1U) == 0) return;
    Sums& sums = all[label];
    least[label] = sums.cells == 0 ? cell.variance : std::min(least[label], cell.variance);
    sums.add(cell, is_curved(regions, label));
  });
  for (int k = 0; k < regions.regions; ++k) {
    if (((wanted >> (k + 1)) & 1U) == 0) continue;
    RegionFit& fit = fits[k] = {};
    const Sums& sums = all[k + 1];
    fit.cells = sums.cells;
    fit.readings = sums.readings;
    if (sums.cells == 0) continue;
    fit.valid = sums.solve(is_curved(regions, k + 1U), fit.surface, fit.residual);
    fit.min_sigma = std::sqrt(double{least[k + 1]});
  }
}

void refit_inside(const RegionMap& regions, std::span<RegionFit> fits) noexcept {
  std::array<Sums, kMaxSurfaces + 1> inner{};
  for (std::uint32_t y = 0; y < regions.cells_high; ++y) {
    for (std::uint32_t x = 0; x < regions.cells_wide; ++x) {
      const std::size_t i = std::size_t{y} * regions.cells_wide + x;
      const Cell& cell = regions.cells[i];
      const std::uint8_t label = regions.labels[i];
      if (label == 0 || cell.n == 0 || !is_inside(regions, x, y)) continue;
      if (is_inlier(cell, fits[label - 1U].surface))
        inner[label].add(cell, is_curved(regions, label));
    }
  }
  for (int k = 0; k < regions.regions; ++k) {
    const Sums& sums = inner[k + 1];
    if (sums.cells < std::max<double>(kInside, kInsideShare * fits[k].cells)) continue;
    FloatSurface surface;
    double residual = 0;
    if (sums.solve(is_curved(regions, k + 1U), surface, residual)) fits[k].surface = surface;
  }
}

namespace {

// How many independent readings' worth of variance the sum over a region has, for each reading: 1
// where the noise of every pixel is its own, more where neighbours share it. Products of the mean
// residuals of cells as far apart as noise reaches say.
double shared_noise(const RegionMap& regions, std::span<const RegionFit> fits) noexcept {
  double products = 0, readings = 0;
  const auto residual = [&](std::uint32_t x, std::uint32_t y) {
    const std::size_t i = std::size_t{y} * regions.cells_wide + x;
    const Cell& cell = regions.cells[i];
    const FloatSurface& s = fits[regions.labels[i] - 1U].surface;
    const double off = double{cell.w} - s.at(double{cell.x}, double{cell.y});
    return double{cell.n} * off / std::sqrt(double{cell.variance});
  };
  for (std::uint32_t y = kReach; y + kReach < regions.cells_high; ++y) {
    for (std::uint32_t x = kReach; x + kReach < regions.cells_wide; ++x) {
      const std::size_t i = std::size_t{y} * regions.cells_wide + x;
      const std::uint8_t label = regions.labels[i];
      if (label == 0 || is_curved(regions, label) || !is_inside(regions, x, y)) continue;
      if (!is_inlier(regions.cells[i], fits[label - 1U].surface)) continue;
      const double here = residual(x, y);
      double around = 0;
      for (std::uint32_t v = y - kReach; v <= y + kReach; ++v) {
        for (std::uint32_t u = x - kReach; u <= x + kReach; ++u) {
          const std::size_t j = std::size_t{v} * regions.cells_wide + u;
          if (regions.labels[j] != label) continue;
          if (!is_inlier(regions.cells[j], fits[label - 1U].surface)) continue;
          around += residual(u, v);
        }
      }
      products += here * around;
      readings += double{regions.cells[i].n};
    }
  }
  return readings > 0 ? std::max(1.0, products / readings) : 1;
}

}  // namespace

void plane_sigmas(const RegionMap& regions, std::span<const RegionFit> fits,
                  std::span<PlaneSigmas> sigmas) noexcept {
  std::array<PlaneSums, kMaxSurfaces + 1> sums{};
  std::array<double, kMaxSurfaces + 1> readings{};
  for_each_cell(regions, [&](const Cell& cell, std::uint8_t label) {
    if (!is_inlier(cell, fits[label - 1U].surface)) return;
    sums[label].add(plane_sums(cell));
    readings[label] += double{cell.n};
  });
  const double shared = shared_noise(regions, fits);
  for (int k = 0; k < regions.regions; ++k) {
    const PlaneSums& s = sums[k + 1];
    sigmas[k] = {};
    if (!(s.n > 0)) continue;
    // Inverse of the normal equations: about the means, then c at the origin.
    const double mx = s.x / s.n, my = s.y / s.n;
    const double xx = s.xx - mx * s.x, xy = s.xy - mx * s.y, yy = s.yy - my * s.y;
    const double determinant = xx * yy - xy * xy;
    if (!(determinant > 0)) continue;
    const double aa = yy / determinant, bb = xx / determinant, ab = -xy / determinant;
    const double cc = 1 / s.n + mx * mx * aa + my * my * bb + 2 * mx * my * ab;
    // Where a plane leaves more than the noise, its coefficients are known less well, too.
    const double residual = s.mean_square(fits[k].surface) * s.n / readings[k + 1];
    const double scale = shared * std::max(1.0, residual);
    sigmas[k] = {std::sqrt(scale * aa), std::sqrt(scale * bb), std::sqrt(scale * cc)};
  }
}

}  // namespace planecast
