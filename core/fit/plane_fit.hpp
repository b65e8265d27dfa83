// Weighted least squares in inverse depth, one plane for each region, from the cells' running sums:
// each cell counts by one over its noise variance.
#pragma once

#include <cstdint>
#include <span>

#include "core/model/region_map.hpp"

namespace planecast {

/// The plane of one region.
struct RegionFit {
  FloatPlane plane;
  double residual = 0;  ///< mean squared residual of a reading, in noise variances
  double readings = 0;
  double min_sigma = 0;  ///< smallest noise of a reading in the region, inverse-depth steps
  std::uint32_t cells = 0;
  bool valid = false;
};

/// Fits region k to fits[k - 1] for k = 1 .. regions.regions; fits.size() >= regions.regions.
/// O(cells); no allocation.
void fit_regions(const RegionMap& regions, std::span<RegionFit> fits) noexcept;

/// Residual of one cell from a plane, in noise variances (mean square of a reading).
inline double cell_residual(const Cell& cell, const FloatPlane& plane) noexcept {
  return cell.sums.mean_square(plane) / cell.variance;
}

}  // namespace planecast
