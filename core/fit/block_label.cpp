#include "core/fit/block_label.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/lanes.hpp"
#include "core/predict/block_surface.hpp"

namespace planecast {
namespace {

constexpr std::uint32_t kBorder = 4;
// Bits: a label that is the left block's, the one above's, or another's; what a surface costs.
constexpr float kAsLeftBits = 0.1F, kAsAboveBits = 2.5F, kOtherBits = 7.0F;
constexpr float kSurfaceBits = 150.0F;
// Bits of n corrections of mean magnitude m: n log2(1 + kSpread m), near enough for comparing.
constexpr float kSpread = 2.5F;
constexpr float kMissCap = 24.0F;
constexpr float kNeighbourSlack = 0.0F, kSurfaceSlack = 0.5F;
// An estimate this much in favour is trusted; without a bound surfaces gain little to lose on.
constexpr float kSureLossless = 1.04F, kSureBounded = 1.0F;

std::size_t row_floats(std::uint32_t width) noexcept {
  return (std::size_t{width} + 7) / 8 * 8 + 2 * kBorder;
}

float bits_of(float misses, float readings) noexcept {
  if (readings <= 0) return 0;
  return readings * std::log2(1.0F + kSpread * misses / readings);
}

// The pixels of a block and their causal neighbours.
struct BlockView {
  const float* first;  ///< level of the block's first pixel
  std::size_t stride;
};

// Correction steps that a residual needs beyond the window. Residuals are taken on true levels,
// but the coder predicts from decoded ones, which stray within the window: the median passes all
// of that on and has no slack left, the surface half (shares measured on recordings).
struct Window {
  Float4 half, per_step;
  Window(int half_width, float share)
      : half(all4(share * static_cast<float>(half_width))),
        per_step(all4(1.0F / static_cast<float>(half_width + half_width / 2 + 1))) {}
  Float4 steps(Float4 residual) const noexcept {
    const Float4 beyond = max4(abs4(residual) - half, all4(0)) * per_step;
    return min4(beyond, all4(kMissCap));
  }
};

// Sum of correction steps with median prediction, over readings whose three neighbours are there.
float neighbour_misses(const BlockView& b, const Window& window, float& readings) noexcept {
  Float4 sum = all4(0), count = all4(0);
  for (int y = 0; y < 8; ++y) {
    const float* row = b.first + y * b.stride;
    for (int x = 0; x < 8; x += 4) {
      const Float4 here = load4(row + x), l = load4(row + x - 1), u = load4(row + x - b.stride),
                   ul = load4(row + x - b.stride - 1);
      const Int4 known = (here > all4(0)) & (l > all4(0)) & (u > all4(0)) & (ul > all4(0));
      const Float4 median = max4(min4(l, u), min4(max4(l, u), l + u - ul));
      sum += keep4(known, window.steps(here - median));
      count += keep4(known, all4(1));
    }
  }
  readings = sum4(count);
  return sum4(sum);
}

// The same with the surface and the neighbours' mean drift from it.
float surface_misses(const BlockView& b, const BlockSurface& s, const Window& window,
                     float limit_levels) noexcept {
  constexpr float kOne = 1.0F / 256;
  const Float4 dx = all4(static_cast<float>(s.dx) * kOne);
  const Float4 dy = all4(static_cast<float>(s.dy) * kOne);
  const Float4 limit = all4(limit_levels);
  Float4 sum = all4(0);
  for (int y = 0; y < 8; ++y) {
    const float* row = b.first + y * b.stride;
    for (int x = 0; x < 8; x += 4) {
      const float at0 = static_cast<float>(s.at_origin + s.dx * x + s.dy * y) * kOne;
      const Float4 at = all4(at0) + dx * Float4{0, 1, 2, 3};
      const Float4 here = load4(row + x), l = load4(row + x - 1), u = load4(row + x - b.stride),
                   ul = load4(row + x - b.stride - 1), ur = load4(row + x - b.stride + 1);
      const Int4 known = (here > all4(0)) & (l > all4(0)) & (u > all4(0)) & (ul > all4(0));
      Float4 drift = all4(0), weight = all4(1e-6F);
      const auto add = [&](Float4 level, Float4 expected, float w) {
        const Float4 off = level - expected;
        const Int4 counts = (level > all4(0)) & (abs4(off) <= limit);
        drift += keep4(counts, off * all4(w));
        weight += keep4(counts, all4(w));
      };
      add(l, at - dx, 4);
      add(u, at - dy, 4);
      add(ul, at - dx - dy, 1);
      add(ur, at + dx - dy, 2);
      const Float4 residual = here - at - all4(0.9F) * drift / weight;
      // Predictions are whole levels.
      const Float4 rounded = to_float4(__builtin_convertvector(abs4(residual) + all4(0.5F), Int4));
      sum += keep4(known, window.steps(rounded));
    }
  }
  return sum4(sum);
}

float label_bits(std::uint8_t label, std::uint8_t left, std::uint8_t above) noexcept {
  if (label == left) return kAsLeftBits;
  return label == above ? kAsAboveBits : kOtherBits;
}

}  // namespace

Candidates block_candidates(const RegionMap& regions, std::span<const std::uint8_t> surface_of,
                            std::uint32_t bx, std::uint32_t by) noexcept {
  Candidates out;
  const auto add = [&](std::uint32_t x, std::uint32_t y) {
    const std::uint8_t label = surface_of[regions.labels[std::size_t{y} * regions.cells_wide + x]];
    if (label == 0 || out.count == 4) return;
    for (int i = 0; i < out.count; ++i) {
      if (out.label[i] == label) return;
    }
    out.label[out.count++] = label;
  };
  add(bx, by);
  const std::uint32_t x0 = bx > 0 ? bx - 1 : 0, y0 = by > 0 ? by - 1 : 0;
  for (std::uint32_t y = y0; y <= std::min(by + 1, regions.cells_high - 1); ++y) {
    for (std::uint32_t x = x0; x <= std::min(bx + 1, regions.cells_wide - 1); ++x) add(x, y);
  }
  return out;
}

void BlockLabeller::layout(Arena& arena, std::uint32_t max_width,
                           std::uint32_t max_height) noexcept {
  levels_ = arena.take<float>(row_floats(max_width) * ((std::size_t{max_height} + 7) / 8 * 8 + 2));
}

void BlockLabeller::load_levels(const FitTables& tables,
                                std::span<const std::uint16_t> depth) noexcept {
  const std::uint32_t width = tables.rays->width, height = tables.rays->height;
  stride_ = row_floats(width);
  const std::size_t rows = (std::size_t{height} + 7) / 8 * 8 + 2;
  float* out = levels_.data();
  std::fill_n(out, stride_, 0.0F);
  for (std::uint32_t v = 0; v < height; ++v) {
    float* row = out + (v + 1) * stride_;
    const std::uint16_t* from = depth.data() + std::size_t{v} * width;
    std::fill_n(row, kBorder, 0.0F);
    for (std::uint32_t u = 0; u < width; ++u) row[kBorder + u] = tables.levels->nearest(from[u]);
    std::fill(row + kBorder + width, row + stride_, 0.0F);
  }
  std::fill_n(out + (height + 1) * stride_, (rows - height - 1) * stride_, 0.0F);
}

void BlockLabeller::process(const FitTables& tables, std::span<const std::uint16_t> depth,
                            const RegionMap& regions, std::span<const std::uint8_t> surface_of,
                            std::span<const Surface> surfaces,
                            std::span<BlockLabel> labels) noexcept {
  std::fill(labels.begin(), labels.end(), BlockLabel{});
  if (surfaces.empty()) return;
  load_levels(tables, depth);
  const std::uint32_t wide = regions.cells_wide, high = regions.cells_high;
  const auto last = static_cast<std::int32_t>(tables.levels->count()) - 1;
  std::array<float, kMaxSurfaces + 1> saved{};
  for (std::uint32_t by = 0; by < high; ++by) {
    for (std::uint32_t bx = 0; bx < wide; ++bx) {
      const Candidates candidates = block_candidates(regions, surface_of, bx, by);
      if (candidates.count == 0) continue;
      const std::size_t block = std::size_t{by} * wide + bx;
      const std::uint8_t left = bx > 0 ? labels[block - 1].first : std::uint8_t{0};
      const std::uint8_t above = by > 0 ? labels[block - wide].first : std::uint8_t{0};
      const BlockView view{levels_.data() + (by * 8 + 1) * stride_ + kBorder + bx * 8, stride_};
      const std::uint8_t* halves = tables.bounds->half_widths(tables.bounds->ray_class(bx, by));
      float best = 0, without = 0, readings = 0;
      std::uint8_t best_label = 0;
      for (int i = 0; i < candidates.count; ++i) {
        const std::uint8_t label = candidates.label[i];
        const BlockSurface s =
            block_surface(surfaces[label - 1U], *tables.rays, *tables.levels, bx, by);
        const std::int32_t middle = std::clamp((s.at(4, 4) + 128) >> 8, 1, last);
        const int half = halves[middle];
        const Window window(half, kNeighbourSlack), surface_window(half, kSurfaceSlack);
        if (i == 0) {
          const float misses = neighbour_misses(view, window, readings);
          without = bits_of(misses, readings);
          best = without + label_bits(0, left, above);
        }
        const float misses =
            surface_misses(view, s, surface_window, static_cast<float>(12 + 3 * half));
        const float sure = half == 0 ? kSureLossless : kSureBounded;
        const float bits = sure * bits_of(misses, readings) + label_bits(label, left, above);
        if (bits < best) {
          best = bits;
          best_label = label;
        }
      }
      labels[block].first = best_label;
      saved[best_label] += without - best;
    }
  }
  for (BlockLabel& label : labels) {
    if (saved[label.first] < kSurfaceBits) label.first = 0;
  }
}

}  // namespace planecast
