// Moments of cells of 4 x 4 pixels: what the surfaces contract tells narrow faces and the borders
// of wide ones by.
#pragma once

#include <cstdint>
#include <span>

#include "core/fit/fit_tables.hpp"
#include "core/model/region_map.hpp"

namespace planecast {

/// Side of a fine cell [px].
inline constexpr std::uint32_t kFineSide = 4;

inline std::uint32_t fine_cells(std::uint32_t pixels) noexcept {
  return (pixels + kFineSide - 1) / kFineSide;
}

/// Fills `cells` (row-major, fine_cells(width) x fine_cells(height)) with the moments of `depth`
/// (row-major counts, 0 = no reading). `noise_factor`: on the noise model's variances, see
/// RegionMap. Sizes were checked by the caller. About 1 ms for 640 x 480; no allocation.
void measure_fine_cells(const FitTables& tables, std::span<const std::uint16_t> depth,
                        float noise_factor, std::span<Cell> cells) noexcept;

/// Readings of the cell whose first pixel is (u0, v0), a bit each, row by row, kFineSide a row.
std::uint32_t cell_readings(const RayTable& rays, std::span<const std::uint16_t> depth,
                            std::uint32_t u0, std::uint32_t v0) noexcept;

/// Measures a cell by the readings `wanted` alone, a subset of cell_readings().
void measure_part(const FitTables& tables, std::span<const std::uint16_t> depth, std::uint32_t u0,
                  std::uint32_t v0, std::uint32_t wanted, float noise_factor, Cell& cell) noexcept;

}  // namespace planecast
