// Sample consensus over the cells of a region: where one plane leaves clearly more than the noise,
// the region holds several, and this takes them apart. Seeded PCG32: the same split every time.
#pragma once

#include <cstdint>
#include <span>

#include "core/fit/plane_fit.hpp"
#include "core/model/region_map.hpp"

namespace planecast {

struct ConsensusOptions {
  double clear_residual = 3.0;   ///< regions at or below it (noise variances) are left alone
  float inlier_residual = 2.0F;  ///< a cell at or below it lies on a plane
  std::uint32_t min_cells = 12;  ///< of a plane worth having
  std::uint32_t trials = 48;     ///< samples of three cells for each plane
  std::uint64_t seed = 1;
};

/// Splits regions in place: cells of the strongest plane keep the label, further planes take new
/// labels up to kMaxSurfaces, cells on none lose theirs. `fits` (kMaxSurfaces long) holds the fits
/// of all regions and is brought up to date. `scratch`: at least cells.size() long. Returns how
/// many regions were split. O(trials * cells of bad regions); no allocation.
int split_regions(RegionMap& regions, std::span<RegionFit> fits, std::span<std::uint32_t> scratch,
                  const ConsensusOptions& options) noexcept;

}  // namespace planecast
