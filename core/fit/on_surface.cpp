#include "core/fit/on_surface.hpp"

#include <algorithm>
#include <bit>
#include <cstdlib>

#include "core/predict/block_surface.hpp"

namespace planecast {
namespace {

constexpr int kMinSecond = 6;

bool on_surface(const FitTables& tables, const Surface& surface, std::uint8_t ray_class,
                std::uint32_t u, std::uint32_t v, std::uint16_t depth) noexcept {
  const std::uint16_t at = surface_depth(surface, tables.rays->x(u, v), tables.rays->y(u, v));
  if (at == 0) return false;
  return static_cast<std::uint32_t>(std::abs(int{at} - int{depth})) <=
         tables.bounds->max_error(depth, ray_class);
}

struct BlockPixels {
  std::uint32_t u0, v0, u1, v1;
  std::uint8_t ray_class;
};

BlockPixels block_pixels(const FitTables& tables, std::uint32_t bx, std::uint32_t by) noexcept {
  return {bx * 8, by * 8, std::min<std::uint32_t>(bx * 8 + 8, tables.rays->width),
          std::min<std::uint32_t>(by * 8 + 8, tables.rays->height),
          tables.bounds->ray_class(bx, by)};
}

// One bit for each pixel of the block: the readings, and those of them on a surface.
std::uint64_t readings_of(const FitTables& tables, std::span<const std::uint16_t> depth,
                          const BlockPixels& b) noexcept {
  std::uint64_t out = 0;
  for (std::uint32_t v = b.v0; v < b.v1; ++v) {
    for (std::uint32_t u = b.u0; u < b.u1; ++u) {
      const bool reading = depth[std::size_t{v} * tables.rays->width + u] != 0;
      out |= std::uint64_t{reading} << ((v - b.v0) * 8 + (u - b.u0));
    }
  }
  return out;
}

std::uint64_t on_bits(const FitTables& tables, std::span<const std::uint16_t> depth,
                      const BlockPixels& b, std::uint64_t wanted, const Surface& surface) noexcept {
  std::uint64_t out = 0;
  for (std::uint64_t rest = wanted; rest != 0; rest &= rest - 1) {
    const auto bit = static_cast<std::uint32_t>(std::countr_zero(rest));
    const std::uint32_t u = b.u0 + bit % 8, v = b.v0 + bit / 8;
    const std::uint16_t d = depth[std::size_t{v} * tables.rays->width + u];
    if (on_surface(tables, surface, b.ray_class, u, v, d)) out |= std::uint64_t{1} << bit;
  }
  return out;
}

}  // namespace

void label_on_surface(const FitTables& tables, std::span<const std::uint16_t> depth,
                      const RegionMap& regions, std::span<const std::uint8_t> surface_of,
                      std::span<const Surface> surfaces, std::span<BlockLabel> labels) noexcept {
  std::fill(labels.begin(), labels.end(), BlockLabel{});
  for (std::uint32_t by = 0; by < regions.cells_high; ++by) {
    for (std::uint32_t bx = 0; bx < regions.cells_wide; ++bx) {
      const Candidates candidates = block_candidates(regions, surface_of, bx, by);
      if (candidates.count == 0) continue;
      const BlockPixels b = block_pixels(tables, bx, by);
      const std::uint64_t readings = readings_of(tables, depth, b);
      if (readings == 0) continue;
      std::uint64_t on[4] = {};
      int first = 0;
      for (int i = 0; i < candidates.count; ++i) {
        on[i] = on_bits(tables, depth, b, readings, surfaces[candidates.label[i] - 1U]);
        if (std::popcount(on[i]) > std::popcount(on[first])) first = i;
      }
      if (on[first] == 0 || std::popcount(on[first]) * 4 < std::popcount(readings)) continue;
      BlockLabel& label = labels[std::size_t{by} * regions.cells_wide + bx];
      label.first = candidates.label[first];
      int most = kMinSecond - 1;
      for (int i = 0; i < candidates.count; ++i) {
        const int more = std::popcount(on[i] & ~on[first]);
        if (i == first || more <= most) continue;
        most = more;
        label.second = candidates.label[i];
      }
    }
  }
}

Status drop_off_surface(const FitTables& tables, std::span<std::uint16_t> depth,
                        std::span<const Surface> surfaces, std::span<const BlockLabel> labels,
                        bool drop, SurfaceCounts& counts) noexcept {
  counts = {};
  const std::uint32_t wide = blocks_wide(tables), high = blocks_high(tables);
  if (depth.size() != std::size_t{tables.rays->width} * tables.rays->height ||
      labels.size() != std::size_t{wide} * high) {
    return Status::kWrongSize;
  }
  for (std::uint32_t by = 0; by < high; ++by) {
    for (std::uint32_t bx = 0; bx < wide; ++bx) {
      const BlockLabel label = labels[std::size_t{by} * wide + bx];
      const BlockPixels b = block_pixels(tables, bx, by);
      const std::uint64_t readings = readings_of(tables, depth, b);
      std::uint64_t on = 0;
      if (label.first != 0) on = on_bits(tables, depth, b, readings, surfaces[label.first - 1U]);
      if (label.second != 0) {
        on |= on_bits(tables, depth, b, readings & ~on, surfaces[label.second - 1U]);
      }
      counts.on += static_cast<std::uint32_t>(std::popcount(on));
      std::uint64_t off = readings & ~on;
      counts.off += static_cast<std::uint32_t>(std::popcount(off));
      if (!drop) continue;
      for (; off != 0; off &= off - 1) {
        const auto bit = static_cast<std::uint32_t>(std::countr_zero(off));
        depth[std::size_t{b.v0 + bit / 8} * tables.rays->width + b.u0 + bit % 8] = 0;
      }
    }
  }
  return Status::kOk;
}

}  // namespace planecast
