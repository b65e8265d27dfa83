// Regions of degree two that are flat after all: a surface that bends also follows an edge between
// two faces, or noise, where planes say the same with fewer coefficients.
#pragma once

#include <cstdint>
#include <span>

#include "core/fit/plane_fit.hpp"

namespace planecast {

/// Makes regions of degree two one plane or two where those explain their readings as well; a
/// second plane takes a new label, up to kMaxSurfaces. `fits` (kMaxSurfaces long) holds the fits of
/// all regions and is brought up to date, `scratch` is at least cells.size() long. Returns how many
/// regions were changed. O(cells of curved regions); no allocation.
int flatten_curved(RegionMap& regions, std::span<RegionFit> fits,
                   std::span<std::uint32_t> scratch) noexcept;

}  // namespace planecast
