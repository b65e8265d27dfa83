// Weighted least squares in inverse depth, one surface for each region, from the cells' moments:
// each cell counts by one over its noise variance.
#pragma once

#include <cstdint>
#include <span>

#include "core/model/region_map.hpp"

namespace planecast {

/// The surface of one region.
struct RegionFit {
  FloatSurface surface;
  double residual = 0;  ///< mean squared residual of a reading, in noise variances
  double readings = 0;
  double min_sigma = 0;  ///< smallest noise of a reading in the region, inverse-depth steps
  std::uint32_t cells = 0;
  bool valid = false;
};

/// Fits region k to fits[k - 1] for k = 1 .. regions.regions whose bit k is in `wanted`;
/// fits.size() >= regions.regions. O(cells); no allocation.
void fit_regions(const RegionMap& regions, std::span<RegionFit> fits,
                 std::uint64_t wanted = ~std::uint64_t{0}) noexcept;

/// Fits the surfaces that fit_regions() found once more, to the cells inside their regions: those
/// at a border may hold readings of another surface, and an outlier's is none of this one. A region
/// keeps its fit where too few are left. O(cells); no allocation.
void refit_inside(const RegionMap& regions, std::span<RegionFit> fits) noexcept;

/// What a plane's coefficients are known to: standard deviations of a, b and c.
struct PlaneSigmas {
  double a = 0, b = 0, c = 0;
};

/// Standard deviations of the planes that RegionRefiner fits, sigmas[k - 1] of region k, from the
/// noise of the fine cells and from how far neighbouring ones share it, measured over the frame.
/// Not meant for regions of degree two. Cold path: O(cells), no allocation.
void plane_sigmas(const RegionMap& regions, std::span<const RegionFit> fits,
                  std::span<PlaneSigmas> sigmas) noexcept;

}  // namespace planecast
