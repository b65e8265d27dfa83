#include "core/fit/fine_cells.hpp"

#include <algorithm>
#include <bit>

#include "core/base/lanes.hpp"
#include "core/model/cell_moments.hpp"
#include "core/model/inverse_noise.hpp"

namespace planecast {
namespace {

constexpr float kRayOne = 1.0F / (1 << 27);
constexpr float kLeastReadings = 5;

// A whole cell under separable rays; dx: four columns, dy: four rows from the cell's origin.
LocalSums whole_sums(const std::uint16_t* depth, std::size_t stride, Float4 dx, Float4 dy,
                     float w0) noexcept {
  Float4 n = all4(0), y = n, yy = n, w = n, yw = n, ww = n;
  for (unsigned v = 0; v < kFineSide; ++v) {
    const Float4 count = load4(depth + v * stride);
    const Int4 reading = count > all4(0);
    const Float4 one = keep4(reading, all4(1)), row = all4(dy[v]);
    const Float4 d = keep4(reading, all4(kInverseDepthOne) / max4(count, all4(1)) - all4(w0));
    n += one;
    y += row * one;
    yy += row * row * one;
    w += d;
    yw += row * d;
    ww += d * d;
  }
  return {sum4(n),  sum4(dx * n), sum4(y),      sum4(dx * dx * n), sum4(dx * y),
          sum4(yy), sum4(w),      sum4(dx * w), sum4(yw),          sum4(ww)};
}

// The readings of any cell whose bit in `wanted` (row by row, kFineSide a row) is set.
LocalSums any_sums(const RayTable& rays, std::span<const std::uint16_t> depth, std::uint32_t u0,
                   std::uint32_t v0, std::uint32_t wanted, float w0) noexcept {
  LocalSums out;
  for (; wanted != 0; wanted &= wanted - 1) {
    const auto bit = static_cast<std::uint32_t>(std::countr_zero(wanted));
    const std::uint32_t u = u0 + bit % kFineSide, v = v0 + bit / kFineSide;
    const float x = static_cast<float>(rays.x(u, v) - rays.x(u0, v0)) * kRayOne;
    const float y = static_cast<float>(rays.y(u, v) - rays.y(u0, v0)) * kRayOne;
    const float w =
        kInverseDepthOne / static_cast<float>(depth[std::size_t{v} * rays.width + u]) - w0;
    out.add(x, y, w);
  }
  return out;
}

// Moments about a cell's first pixel and w0 become those of the cell.
void set_cell(const LocalSums& sums, const RayTable& rays, std::uint32_t u0, std::uint32_t v0,
              float w0, const InverseNoise& noise, float noise_factor, Cell& cell) noexcept {
  const bool spread = set_moments(sums, cell);
  cell.x += static_cast<float>(rays.x(u0, v0)) * kRayOne;
  cell.y += static_cast<float>(rays.y(u0, v0)) * kRayOne;
  cell.w += w0;
  const double sigma = noise.sigma(double{cell.w});
  cell.variance = noise_factor * static_cast<float>(sigma * sigma);
  cell.usable = cell.flat = spread && cell.n >= kLeastReadings;
}

}  // namespace

std::uint32_t cell_readings(const RayTable& rays, std::span<const std::uint16_t> depth,
                            std::uint32_t u0, std::uint32_t v0) noexcept {
  std::uint32_t out = 0;
  for (std::uint32_t v = v0; v < std::min<std::uint32_t>(v0 + kFineSide, rays.height); ++v) {
    for (std::uint32_t u = u0; u < std::min<std::uint32_t>(u0 + kFineSide, rays.width); ++u) {
      const bool reading = depth[std::size_t{v} * rays.width + u] != 0;
      out |= std::uint32_t{reading} << ((v - v0) * kFineSide + u - u0);
    }
  }
  return out;
}

void measure_part(const FitTables& tables, std::span<const std::uint16_t> depth, std::uint32_t u0,
                  std::uint32_t v0, std::uint32_t wanted, float noise_factor, Cell& cell) noexcept {
  cell = {};
  if (wanted == 0) return;
  const auto bit = static_cast<std::uint32_t>(std::countr_zero(wanted));
  const std::size_t first =
      std::size_t{v0 + bit / kFineSide} * tables.rays->width + u0 + bit % kFineSide;
  const float w0 = kInverseDepthOne / static_cast<float>(depth[first]);
  set_cell(any_sums(*tables.rays, depth, u0, v0, wanted, w0), *tables.rays, u0, v0, w0,
           InverseNoise(*tables.config), noise_factor, cell);
}

void measure_fine_cells(const FitTables& tables, std::span<const std::uint16_t> depth,
                        float noise_factor, std::span<Cell> cells) noexcept {
  const RayTable& rays = *tables.rays;
  const InverseNoise noise(*tables.config);
  const std::uint32_t cells_wide = fine_cells(rays.width), cells_high = fine_cells(rays.height);
  for (std::uint32_t cy = 0; cy < cells_high; ++cy) {
    const std::uint32_t v0 = cy * kFineSide;
    const std::uint32_t high = std::min<std::uint32_t>(kFineSide, rays.height - v0);
    Float4 dy = all4(0);
    if (rays.separable) {
      for (std::uint32_t v = 0; v < high; ++v)
        dy[v] = static_cast<float>(rays.y(0, v0 + v) - rays.y(0, v0)) * kRayOne;
    }
    for (std::uint32_t cx = 0; cx < cells_wide; ++cx) {
      const std::uint32_t u0 = cx * kFineSide;
      const std::uint32_t wide = std::min<std::uint32_t>(kFineSide, rays.width - u0);
      const std::uint16_t* first = depth.data() + std::size_t{v0} * rays.width + u0;
      Cell& cell = cells[std::size_t{cy} * cells_wide + cx];
      cell = {};
      const float w0 = cell_origin(first, rays.width, wide, high);
      if (w0 == 0) continue;
      LocalSums sums;
      if (rays.separable && wide == kFineSide && high == kFineSide) {
        const Float4 dx =
            to_float4(load4(&rays.x_q27[u0])) - all4(static_cast<float>(rays.x(u0, v0)));
        sums = whole_sums(first, rays.width, dx * all4(kRayOne), dy, w0);
      } else {
        sums = any_sums(rays, depth, u0, v0, cell_readings(rays, depth, u0, v0), w0);
      }
      set_cell(sums, rays, u0, v0, w0, noise, noise_factor, cell);
    }
  }
}

}  // namespace planecast
