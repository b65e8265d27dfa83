#include "core/fit/plane_fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace planecast {

void fit_regions(const RegionMap& regions, std::span<RegionFit> fits) noexcept {
  std::array<PlaneSums, kMaxSurfaces + 1> sums{};
  std::array<float, kMaxSurfaces + 1> least{};
  for (int k = 0; k < regions.regions; ++k) fits[k] = {};
  for (std::size_t i = 0; i < regions.cells.size(); ++i) {
    const unsigned label = regions.labels[i];
    const Cell& cell = regions.cells[i];
    if (label == 0 || cell.sums.n == 0) continue;
    sums[label].add(cell.sums, 1.0 / cell.variance);
    RegionFit& fit = fits[label - 1];
    fit.readings += cell.sums.n;
    least[label] = fit.cells == 0 ? cell.variance : std::min(least[label], cell.variance);
    ++fit.cells;
  }
  for (int k = 0; k < regions.regions; ++k) {
    RegionFit& fit = fits[k];
    const PlaneSums& s = sums[k + 1];
    if (fit.cells == 0 || !s.solve(fit.plane)) continue;
    fit.valid = true;
    fit.min_sigma = std::sqrt(static_cast<double>(least[k + 1]));
    fit.residual = s.mean_square(fit.plane) * s.n / fit.readings;
  }
}

}  // namespace planecast
