#include "core/fit/on_surface.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>

#include "core/base/lanes.hpp"
#include "core/model/cell_moments.hpp"
#include "core/predict/block_surface.hpp"

namespace planecast {
namespace {

// Readings for which a block takes a second surface, of its own regions and of a neighbour: each
// costs a choice for every pixel. Where readings off the surfaces are dropped, they cost less than
// that choice, and only a second surface that holds more of them is one.
struct LeastSecond {
  int own = 6, taken = 12;
};

LeastSecond least_second(const FitTables& tables) noexcept {
  if (tables.config->drop_off_surface) return {10, 14};
  return {};
}

bool on_surface(const FitTables& tables, const Surface& surface, std::uint8_t ray_class,
                std::uint32_t u, std::uint32_t v, std::uint16_t depth) noexcept {
  const std::uint16_t at = surface_depth(surface, tables.rays->x(u, v), tables.rays->y(u, v));
  if (at == 0) return false;
  return static_cast<std::uint32_t>(std::abs(int{at} - int{depth})) <=
         tables.bounds->max_error(depth, ray_class);
}

// Where a block is, its readings as one bit each, and the bounds of them [counts].
struct BlockPixels {
  std::uint32_t u0, v0, u1, v1;
  std::uint8_t ray_class;
  std::uint64_t readings = 0;
  float least = 0, most = 0;

  bool whole_rows() const noexcept { return u1 - u0 == 8; }
};

// Readings of eight columns, and the depths of the nearest and the farthest one.
void look_at_rows(const FitTables& tables, std::span<const std::uint16_t> depth,
                  BlockPixels& b) noexcept {
  constexpr float kFar = 65535;
  Float4 nearest = all4(kFar), farthest = all4(1);
  for (std::uint32_t v = b.v0; v < b.v1; ++v) {
    const std::uint16_t* row = &depth[std::size_t{v} * tables.rays->width + b.u0];
    for (unsigned half = 0; half < 8; half += 4) {
      const Float4 here = load4(row + half);
      const Int4 reading = here > all4(0);
      b.readings |= std::uint64_t{lane_bits(reading)} << ((v - b.v0) * 8 + half);
      farthest = max4(farthest, here);
      nearest = min4(nearest, reading ? here : all4(kFar));
    }
  }
  float low = kFar, high = 1;
  for (int i = 0; i < 4; ++i) {
    low = std::min(low, nearest[i]);
    high = std::max(high, farthest[i]);
  }
  const auto bound = [&](float d) {
    return static_cast<float>(tables.bounds->max_error(static_cast<std::uint16_t>(d), b.ray_class));
  };
  const float one = bound(low), other = bound(high);
  b.least = std::min(one, other);
  b.most = std::max(one, other);
}

BlockPixels block_pixels(const FitTables& tables, std::span<const std::uint16_t> depth,
                         std::uint32_t bx, std::uint32_t by) noexcept {
  BlockPixels b{bx * 8, by * 8, std::min<std::uint32_t>(bx * 8 + 8, tables.rays->width),
                std::min<std::uint32_t>(by * 8 + 8, tables.rays->height),
                tables.bounds->ray_class(bx, by)};
  if (b.whole_rows()) {
    look_at_rows(tables, depth, b);
    return b;
  }
  for (std::uint32_t v = b.v0; v < b.v1; ++v) {
    for (std::uint32_t u = b.u0; u < b.u1; ++u) {
      const bool reading = depth[std::size_t{v} * tables.rays->width + u] != 0;
      b.readings |= std::uint64_t{reading} << ((v - b.v0) * 8 + (u - b.u0));
    }
  }
  return b;
}

// What floats can tell of a block's pixels: surely on the surface, and not surely off it.
struct Verdict {
  std::uint64_t on = 0, open = 0;
};

// A surface in floats over the rays of one block.
struct FloatSurfaceLanes {
  float a, b, c, d, e, f;
  float rounding = 0;  // of a depth, relative to its square

  FloatSurfaceLanes(const Surface& s, float x, float y)
      : a(static_cast<float>(s.a)),
        b(static_cast<float>(s.b)),
        c(static_cast<float>(s.c)),
        d(static_cast<float>(s.d)),
        e(static_cast<float>(s.e)),
        f(static_cast<float>(s.f)) {
    constexpr float kRounding = 1e-6F;
    const float size = std::abs(a) * x + std::abs(b) * y + std::abs(c) + std::abs(d) * x * x +
                       std::abs(e) * x * y + std::abs(f) * y * y + 64;
    rounding = kRounding * size / kInverseDepthOne;
  }
  template <bool Curved>
  Float4 inverse_depth(Float4 x, Float4 y) const noexcept {
    const Float4 plane = all4(a) * x + (all4(b) * y + all4(c));
    if constexpr (!Curved) return plane;
    return plane + x * (all4(d) * x + all4(e) * y) + all4(f) * y * y;
  }
};

template <bool Curved>
Verdict judge(const FitTables& tables, std::span<const std::uint16_t> depth, const BlockPixels& b,
              const FloatSurfaceLanes& surface) noexcept {
  constexpr float kRayOne = 1.0F / (1 << 27);
  const RayTable& rays = *tables.rays;
  Verdict out;
  for (std::uint32_t v = b.v0; v < b.v1; ++v) {
    const std::size_t row = std::size_t{v} * rays.width + b.u0;
    for (std::uint32_t half = 0; half < 8; half += 4) {
      const std::int32_t* xs = &rays.x_q27[(rays.separable ? b.u0 : row) + half];
      const Float4 x = to_float4(load4(xs)) * all4(kRayOne);
      const Float4 y = rays.separable ? all4(static_cast<float>(rays.y_q27[v]) * kRayOne)
                                      : to_float4(load4(&rays.y_q27[row + half])) * all4(kRayOne);
      const Float4 there =
          all4(kInverseDepthOne) / max4(surface.inverse_depth<Curved>(x, y), all4(16384));
      const Float4 off = abs4(there - load4(&depth[row + half]));
      const Float4 slack = there * there * all4(surface.rounding) + all4(2);
      const unsigned shift = (v - b.v0) * 8 + half;
      const Int4 on = (off + slack <= all4(b.least)) & (there < all4(65000));
      out.on |= std::uint64_t{lane_bits(on)} << shift;
      out.open |= std::uint64_t{lane_bits(off - slack <= all4(b.most))} << shift;
    }
  }
  return out;
}

// Exactly, by the decoder's own arithmetic.
std::uint64_t exactly_on(const FitTables& tables, std::span<const std::uint16_t> depth,
                         const BlockPixels& b, std::uint64_t wanted,
                         const Surface& surface) noexcept {
  std::uint64_t out = 0;
  for (std::uint64_t rest = wanted; rest != 0; rest &= rest - 1) {
    const auto bit = static_cast<std::uint32_t>(std::countr_zero(rest));
    const std::uint32_t u = b.u0 + bit % 8, v = b.v0 + bit / 8;
    const std::uint16_t d = depth[std::size_t{v} * tables.rays->width + u];
    if (on_surface(tables, surface, b.ray_class, u, v, d)) out |= std::uint64_t{1} << bit;
  }
  return out;
}

// The wanted readings of a block that lie on a surface. Floats settle most of them; the rest, near
// the bound, is looked at exactly.
std::uint64_t on_bits(const FitTables& tables, std::span<const std::uint16_t> depth,
                      const BlockPixels& b, std::uint64_t wanted, const Surface& surface) noexcept {
  if (!b.whole_rows() || wanted == 0) return exactly_on(tables, depth, b, wanted, surface);
  const RayTable& rays = *tables.rays;
  float x = 0, y = 0;
  for (const std::uint32_t u : {b.u0, b.u1 - 1}) {
    for (const std::uint32_t v : {b.v0, b.v1 - 1}) {
      x = std::max(x, std::abs(static_cast<float>(rays.x(u, v))) * 0x1p-27F);
      y = std::max(y, std::abs(static_cast<float>(rays.y(u, v))) * 0x1p-27F);
    }
  }
  // Distortion may reach a little further inside a block than at its corners.
  const FloatSurfaceLanes lanes(surface, 1.1F * x, 1.1F * y);
  const Verdict verdict = surface.curved() ? judge<true>(tables, depth, b, lanes)
                                           : judge<false>(tables, depth, b, lanes);
  const std::uint64_t on = wanted & verdict.on;
  return on | exactly_on(tables, depth, b, wanted & verdict.open & ~verdict.on, surface);
}

// Surfaces of the fine cells in and around a block: those with most cells, cells inside counting
// more than those around.
Candidates fine_candidates(const RegionMap& regions, std::span<const std::uint8_t> surface_of,
                           std::uint32_t bx, std::uint32_t by) noexcept {
  constexpr int kInside = 5;
  const std::uint32_t x0 = bx > 0 ? 2 * bx - 1 : 0, y0 = by > 0 ? 2 * by - 1 : 0;
  std::uint8_t label[16];
  int times[16], count = 0;
  for (std::uint32_t y = y0; y < std::min(2 * by + 3, regions.cells_high); ++y) {
    for (std::uint32_t x = x0; x < std::min(2 * bx + 3, regions.cells_wide); ++x) {
      const std::uint8_t here = surface_of[regions.labels[std::size_t{y} * regions.cells_wide + x]];
      if (here == 0) continue;
      int k = 0;
      while (k < count && label[k] != here) ++k;
      if (k == count) {
        label[count] = here;
        times[count++] = 0;
      }
      times[k] += x / 2 == bx && y / 2 == by ? kInside : 1;
    }
  }
  Candidates out;
  while (out.count < 4) {
    int best = -1;
    for (int k = 0; k < count; ++k) {
      if (times[k] > 0 && (best < 0 || times[k] > times[best])) best = k;
    }
    if (best < 0) break;
    times[best] = 0;
    out.label[out.count++] = label[best];
  }
  return out;
}

// Gives a block the surface of a neighbour that most of its readings off its own lie on: narrow
// things go on where no cell of theirs is pure. A block without any surface takes one that holds
// half of its readings.
void take_from_neighbours(const FitTables& tables, std::span<const std::uint16_t> depth,
                          std::span<const Surface> surfaces, std::uint32_t bx, std::uint32_t by,
                          std::span<BlockLabel> labels, std::span<std::uint64_t> off) noexcept {
  const std::uint32_t wide = blocks_wide(tables), high = blocks_high(tables);
  const std::size_t block = std::size_t{by} * wide + bx;
  BlockLabel& label = labels[block];
  int least = least_second(tables).taken;
  if (label.first == 0) least = std::max(least, std::popcount(off[block]) / 2);
  if (label.second != 0 || std::popcount(off[block]) < least) return;
  const BlockPixels b = block_pixels(tables, depth, bx, by);
  std::uint64_t tried = std::uint64_t{1} | (std::uint64_t{1} << label.first), best_on = 0;
  std::uint8_t best = 0;
  const auto offer = [&](std::uint8_t next) {
    if (((tried >> next) & 1U) != 0) return;
    tried |= std::uint64_t{1} << next;
    const std::uint64_t on = on_bits(tables, depth, b, off[block], surfaces[next - 1U]);
    if (std::popcount(on) < least || std::popcount(on) <= std::popcount(best_on)) return;
    best = next;
    best_on = on;
  };
  for (std::uint32_t y = by > 0 ? by - 1 : 0; y <= std::min(by + 1, high - 1); ++y) {
    for (std::uint32_t x = bx > 0 ? bx - 1 : 0; x <= std::min(bx + 1, wide - 1); ++x) {
      offer(labels[std::size_t{y} * wide + x].first);
      offer(labels[std::size_t{y} * wide + x].second);
    }
  }
  if (best == 0) return;
  (label.first == 0 ? label.first : label.second) = best;
  off[block] &= ~best_on;
}

}  // namespace

void label_on_surface(const FitTables& tables, std::span<const std::uint16_t> depth,
                      const RegionMap& regions, std::span<const std::uint8_t> surface_of,
                      std::span<const Surface> surfaces, std::span<BlockLabel> labels,
                      std::span<std::uint64_t> off) noexcept {
  const int least = least_second(tables).own;
  const std::uint32_t wide = blocks_wide(tables), high = blocks_high(tables);
  for (std::uint32_t by = 0; by < high; ++by) {
    for (std::uint32_t bx = 0; bx < wide; ++bx) {
      const std::size_t block = std::size_t{by} * wide + bx;
      BlockLabel& label = labels[block];
      label = {};
      const BlockPixels b = block_pixels(tables, depth, bx, by);
      const std::uint64_t readings = off[block] = b.readings;
      if (readings == 0) continue;
      const Candidates candidates = fine_candidates(regions, surface_of, bx, by);
      std::uint64_t on[4] = {};
      int first = 0;
      for (int i = 0; i < candidates.count; ++i) {
        on[i] = on_bits(tables, depth, b, readings, surfaces[candidates.label[i] - 1U]);
        if (std::popcount(on[i]) > std::popcount(on[first])) first = i;
      }
      if (on[first] == 0 || std::popcount(on[first]) * 4 < std::popcount(readings)) continue;
      label.first = candidates.label[first];
      off[block] &= ~on[first];
      std::uint64_t more = 0;
      for (int i = 0; i < candidates.count; ++i) {
        const std::uint64_t rest = on[i] & off[block];
        if (std::popcount(rest) < least || std::popcount(rest) <= std::popcount(more)) continue;
        more = rest;
        label.second = candidates.label[i];
      }
      off[block] &= ~more;
    }
  }
  for (std::uint32_t i = 0; i < wide * high; ++i)
    take_from_neighbours(tables, depth, surfaces, i % wide, i / wide, labels, off);
  for (std::uint32_t i = wide * high; i-- > 0;)
    take_from_neighbours(tables, depth, surfaces, i % wide, i / wide, labels, off);
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
      const BlockPixels b = block_pixels(tables, depth, bx, by);
      const std::uint64_t readings = b.readings;
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
