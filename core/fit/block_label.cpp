#include "core/fit/block_label.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "core/base/lanes.hpp"
#include "core/predict/block_surface.hpp"

namespace planecast {
namespace {

constexpr std::uint32_t kBorder = 4;
// Bits: a label that is the left block's, the one above's, or another's; what a surface costs.
constexpr float kAsLeftBits = 0.1F, kAsAboveBits = 2.5F, kOtherBits = 7.0F;
constexpr float kSurfaceBitsLossless = 200.0F, kSurfaceBitsBounded = 500.0F;
// A surface of degree two has twice the coefficients to send.
constexpr float kCurvedCost = 1.5F;
// What a surface saves at most where a block is flat without it (docs/wire-format.md, "Flat
// blocks"): its plane is foretold by the blocks around nearly as well.
constexpr float kFlatSaves = 1.5F;
// A flat block's label is worth little, and found by how far the surface lies from the block's own
// plane (misfit()): bits it gains at most, and fewer by each window; its own region's surface is
// not compared with others where it is this near.
constexpr float kFlatGain = 25.0F, kFlatLoss = 3.0F, kNear = 4.0F;
// Bits of n corrections of mean magnitude m: n log2(1 + kSpread m), near enough for comparing.
constexpr float kSpread = 2.5F;
constexpr float kMissCap = 24.0F;
// How much a block says about its own label where each of its four neighbours says one.
constexpr float kLosslessSay = 2, kBoundedSay = 8;
constexpr float kNeighbourSlack = 0.0F, kSurfaceSlack = 0.5F;
// An estimate this much in favour is trusted; without a bound surfaces gain little to lose on.
constexpr float kSureLossless = 1.04F, kSureBounded = 1.0F;

constexpr std::uint32_t kMostHeldRows = 8;

// Some rows of a block tell what all eight would, each with the one above it: fewer where a bound
// makes the answer clear.
struct SampledRows {
  std::uint32_t row[4];
  std::uint32_t count;
  float share;  ///< pixels that each sampled one stands for
};
constexpr SampledRows kLosslessRows{{1, 3, 5, 7}, 4, 2}, kBoundedRows{{2, 6}, 2, 4};

const SampledRows& rows_of(const FitTables& tables) noexcept {
  return tables.bounds->lossless() ? kLosslessRows : kBoundedRows;
}

std::size_t row_floats(std::uint32_t width) noexcept {
  return (std::size_t{width} + 7) / 8 * 8 + 2 * kBorder;
}

// Base-2 logarithm of x >= 1 to 0.01, the same on every machine.
float log2_about(float x) noexcept {
  const auto bits = std::bit_cast<std::uint32_t>(x);
  const float mantissa = std::bit_cast<float>((bits & 0x7fffffU) | 0x3f800000U);
  const auto exponent = static_cast<float>(static_cast<std::int32_t>(bits >> 23U) - 127);
  return exponent + (2 - mantissa * (1.0F / 3)) * mantissa - 5.0F / 3;
}

float bits_of(float misses, float readings) noexcept {
  if (readings <= 0) return 0;
  return readings * log2_about(1.0F + kSpread * misses / readings);
}

// The sampled rows of a block: level of the first pixel, row above, row, and so on.
struct BlockView {
  const float* first;
  std::size_t stride;
  const SampledRows* rows;
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
  for (std::uint32_t i = 0; i < b.rows->count; ++i) {
    const float* row = b.first + (2 * i + 1) * b.stride;
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
  for (std::uint32_t i = 0; i < b.rows->count; ++i) {
    const float* row = b.first + (2 * i + 1) * b.stride;
    const auto y = static_cast<std::int32_t>(b.rows->row[i]);
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

// A plane of the block's own, in levels: at its middle and by pixel, and how far the farthest
// reading is from it. All zeroes where there is no reading.
struct OwnPlane {
  float middle = 0, dx = 0, dy = 0, farthest = 0;
};

// Least squares over rows 1, 2, 5 and 6, so that the sums about the middle need no solving.
OwnPlane own_plane(const BlockView& b) noexcept {
  constexpr float kRowOffset[4] = {-2.5F, -1.5F, 1.5F, 2.5F};
  constexpr float kSquaresX = 168, kSquaresY = 136;
  const Float4 at_x[2] = {{-3.5F, -2.5F, -1.5F, -0.5F}, {0.5F, 1.5F, 2.5F, 3.5F}};
  Float4 sum = all4(0), count = all4(0);
  for (std::uint32_t i = 0; i < 4; ++i) {
    for (int k = 0; k < 2; ++k) {
      const Float4 here = load4(b.first + i * b.stride + 4 * k);
      sum += here;
      count += keep4(here > all4(0), all4(1));
    }
  }
  const float readings = sum4(count);
  if (readings == 0) return {};
  const Float4 mean = all4(sum4(sum) / readings);
  Float4 along = all4(0), down = all4(0);
  for (std::uint32_t i = 0; i < 4; ++i) {
    for (int k = 0; k < 2; ++k) {
      const Float4 here = load4(b.first + i * b.stride + 4 * k);
      const Float4 off = keep4(here > all4(0), here - mean);  // a hole pulls nowhere
      along += off * at_x[k];
      down += off * all4(kRowOffset[i]);
    }
  }
  const Float4 dx = all4(sum4(along) / kSquaresX), dy = all4(sum4(down) / kSquaresY);
  Float4 most = all4(0);
  for (std::uint32_t i = 0; i < 4; ++i) {
    for (int k = 0; k < 2; ++k) {
      const Float4 here = load4(b.first + i * b.stride + 4 * k);
      const Float4 plane = mean + dx * at_x[k] + dy * all4(kRowOffset[i]);
      most = max4(most, keep4(here > all4(0), abs4(here - plane)));
    }
  }
  return {mean[0], dx[0], dy[0], std::max(std::max(most[0], most[1]), std::max(most[2], most[3]))};
}

// How far a surface lies from a block's own plane, in windows of `half` levels: in the middle, and
// by how it is tilted towards the corners, which a few steps of slope mend less cheaply.
float misfit(const BlockSurface& s, const OwnPlane& plane, float half) noexcept {
  constexpr float kOne = 1.0F / 256, kCorner = 3.5F, kTilt = 2.6F;
  const float dx = static_cast<float>(s.dx) * kOne, dy = static_cast<float>(s.dy) * kOne;
  const float middle = static_cast<float>(s.at_origin) * kOne + kCorner * (dx + dy);
  const float tilt = kCorner * (std::abs(dx - plane.dx) + std::abs(dy - plane.dy));
  return (std::abs(middle - plane.middle) + kTilt * tilt) / half;
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
  levels_ = arena.take<float>(row_floats(max_width) * kMostHeldRows);
  offers_ = arena.take<Offer>(std::size_t{(max_width + 7) / 8} * ((max_height + 7) / 8));
}

// Levels of the sampled rows of a row of blocks; rows and columns beyond the image are holes.
void BlockLabeller::load_levels(const FitTables& tables, std::span<const std::uint16_t> depth,
                                std::uint32_t by) noexcept {
  const std::uint32_t width = tables.rays->width, height = tables.rays->height;
  stride_ = row_floats(width);
  const LevelTable levels = *tables.levels;
  const SampledRows& rows = rows_of(tables);
  for (std::uint32_t i = 0; i < 2 * rows.count; ++i) {
    float* row = levels_.data() + i * stride_;
    const std::uint32_t v = by * 8 + rows.row[i / 2] - (i % 2 == 0 ? 1 : 0);
    if (v >= height) {
      std::fill_n(row, stride_, 0.0F);
      continue;
    }
    const std::uint16_t* from = depth.data() + std::size_t{v} * width;
    std::fill_n(row, kBorder, 0.0F);
    for (std::uint32_t u = 0; u < width; ++u) row[kBorder + u] = levels.nearest(from[u]);
    std::fill(row + kBorder + width, row + stride_, 0.0F);
  }
}

void BlockLabeller::process(const FitTables& tables, std::span<const std::uint16_t> depth,
                            const RegionMap& regions, std::span<const std::uint8_t> surface_of,
                            std::span<const Surface> surfaces,
                            std::span<BlockLabel> labels) noexcept {
  std::fill(labels.begin(), labels.end(), BlockLabel{});
  if (surfaces.empty()) return;
  for (std::uint32_t by = 0; by < regions.cells_high; ++by) {
    load_levels(tables, depth, by);
    for (std::uint32_t bx = 0; bx < regions.cells_wide; ++bx) {
      offers_[std::size_t{by} * regions.cells_wide + bx] =
          offer_of(tables, regions, surface_of, surfaces, bx, by);
    }
  }
  const bool lossless = tables.bounds->lossless();
  choose(regions, lossless ? kLosslessSay : kBoundedSay,
         lossless ? kSurfaceBitsLossless : kSurfaceBitsBounded, surfaces, labels);
}

// Of a block that is flat, as most are, by its own plane; of any other the best one.
BlockLabeller::Offer BlockLabeller::offer_of(const FitTables& tables, const RegionMap& regions,
                                             std::span<const std::uint8_t> surface_of,
                                             std::span<const Surface> surfaces, std::uint32_t bx,
                                             std::uint32_t by) const noexcept {
  const auto candidates = [&] { return block_candidates(regions, surface_of, bx, by); };
  if (tables.bounds->lossless()) return best_offer(tables, candidates(), surfaces, bx, by);
  const OwnPlane plane = own_plane({levels_.data() + kBorder + bx * 8, stride_, nullptr});
  const auto middle = static_cast<std::int32_t>(plane.middle + 0.5F);
  const int level_half = tables.bounds->half_widths(tables.bounds->ray_class(bx, by))[middle];
  const auto half = static_cast<float>(level_half);
  if (middle == 0 || level_half == 0 || plane.farthest > half + 0.5F)
    return best_offer(tables, candidates(), surfaces, bx, by);
  const auto misfit_of = [&](std::uint8_t label) {
    return misfit(block_surface(surfaces[label - 1U], *tables.rays, *tables.levels, bx, by), plane,
                  half);
  };
  const std::uint8_t own = surface_of[regions.labels[std::size_t{by} * regions.cells_wide + bx]];
  if (own != 0 && misfit_of(own) < kNear) return {kFlatGain, own, true};
  Offer best;
  const Candidates around = candidates();
  for (int i = 0; i < around.count; ++i) {
    const std::uint8_t label = around.label[i];
    const float gain = std::max(0.0F, kFlatGain - kFlatLoss * misfit_of(label));
    if (best.label == 0 || gain > best.gain) best = {gain, label, true};
  }
  return best;
}

// The surface that a block gains most by.
BlockLabeller::Offer BlockLabeller::best_offer(const FitTables& tables,
                                               const Candidates& candidates,
                                               std::span<const Surface> surfaces, std::uint32_t bx,
                                               std::uint32_t by) const noexcept {
  Offer best;
  if (candidates.count == 0) return best;
  const auto last = static_cast<std::int32_t>(tables.levels->count()) - 1;
  const BlockView view{levels_.data() + kBorder + bx * 8, stride_, &rows_of(tables)};
  const std::uint8_t* halves = tables.bounds->half_widths(tables.bounds->ray_class(bx, by));
  const std::size_t block = std::size_t{by} * blocks_wide(tables) + bx;
  const std::uint8_t left = bx > 0 ? offers_[block - 1].label : std::uint8_t{0};
  const std::uint8_t above = by > 0 ? offers_[block - blocks_wide(tables)].label : std::uint8_t{0};
  float without = 0, readings = 0, best_worth = 0;
  for (int i = 0; i < candidates.count; ++i) {
    const std::uint8_t label = candidates.label[i];
    // No surface misses less than nothing.
    if (best.label != 0 &&
        view.rows->share * without - label_bits(label, left, above) <= best_worth)
      continue;
    const BlockSurface s =
        block_surface(surfaces[label - 1U], *tables.rays, *tables.levels, bx, by);
    const std::int32_t middle = std::clamp((s.at(4, 4) + 128) >> 8, 1, last);
    const int half = halves[middle];
    const Window window(half, kNeighbourSlack), surface_window(half, kSurfaceSlack);
    if (i == 0) {
      const float misses = neighbour_misses(view, window, readings);
      without = bits_of(misses, readings);
    }
    const float misses = surface_misses(view, s, surface_window, static_cast<float>(12 + 3 * half));
    const float sure = half == 0 ? kSureLossless : kSureBounded;
    const float gain = view.rows->share * (without - sure * bits_of(misses, readings));
    const float worth = gain - label_bits(label, left, above);
    if (best.label != 0 && worth <= best_worth) continue;
    best = {gain, label, false};
    best_worth = worth;
  }
  return best;
}

// Takes the offers that pay for their label. A few pixels say little of one block, more when those
// next to it with the same offer have a say.
void BlockLabeller::choose(const RegionMap& regions, float own_say, float least,
                           std::span<const Surface> surfaces,
                           std::span<BlockLabel> labels) noexcept {
  const std::uint32_t wide = regions.cells_wide, high = regions.cells_high;
  std::array<float, kMaxSurfaces + 1> saved{};
  for (std::uint32_t by = 0; by < high; ++by) {
    for (std::uint32_t bx = 0; bx < wide; ++bx) {
      const std::size_t block = std::size_t{by} * wide + bx;
      const Offer& offer = offers_[block];
      if (offer.label == 0) continue;
      float sum = own_say * offer.gain, weight = own_say;
      const auto ask = [&](const Offer& other) {
        if (other.label != offer.label) return;
        sum += other.gain;
        weight += 1;
      };
      if (bx > 0) ask(offers_[block - 1]);
      if (bx + 1 < wide) ask(offers_[block + 1]);
      if (by > 0) ask(offers_[block - wide]);
      if (by + 1 < high) ask(offers_[block + wide]);
      const std::uint8_t left = bx > 0 ? labels[block - 1].first : std::uint8_t{0};
      const std::uint8_t above = by > 0 ? labels[block - wide].first : std::uint8_t{0};
      const float gain =
          sum / weight + label_bits(0, left, above) - label_bits(offer.label, left, above);
      if (gain <= 0) continue;
      labels[block].first = offer.label;
      saved[offer.label] += offer.flat ? std::min(gain, kFlatSaves) : gain;
    }
  }
  for (BlockLabel& label : labels) {
    if (label.first == 0) continue;
    const float cost = surfaces[label.first - 1U].curved() ? kCurvedCost * least : least;
    if (saved[label.first] < cost) label.first = 0;
  }
}

}  // namespace planecast
