#include "core/filter/outlier_filter.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/lanes.hpp"

namespace planecast {
namespace {

constexpr std::uint32_t kBorder = 4;    // floats before and after a row, holes
constexpr float kNoNeighbour = 1.0e6F;  // stands for a difference to a hole
constexpr float kIsolated = 1.0e9F;
constexpr float kHole = -1.0F;

std::size_t row_floats(std::uint32_t width) noexcept {
  return (std::size_t{width} + 3) / 4 * 4 + 2 * kBorder;
}

// Distance to a neighbour, or kNoNeighbour.
inline Float4 difference(Float4 here, Float4 there) noexcept {
  const Int4 valid = there > all4(0);
  return valid ? abs4(here - there) : all4(kNoNeighbour);
}

}  // namespace

std::uint32_t apply_range_gate(std::span<std::uint16_t> depth, std::uint16_t min_count,
                               std::uint16_t max_count) noexcept {
  // Blocks short enough to count in 16 bits: eight readings a step on any machine.
  constexpr std::size_t kBlock = 4096;
  std::uint32_t outside = 0;
  for (std::size_t begin = 0; begin < depth.size(); begin += kBlock) {
    std::uint16_t* const d = depth.data() + begin;
    const std::size_t count = std::min(kBlock, depth.size() - begin);
    std::uint16_t out_here = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const auto low = static_cast<std::uint16_t>(d[i] < min_count ? 1 : 0);
      const auto high = static_cast<std::uint16_t>(d[i] > max_count ? 1 : 0);
      const auto there = static_cast<std::uint16_t>(d[i] != 0 ? 1 : 0);
      const auto out = static_cast<std::uint16_t>((low | high) & there);
      out_here = static_cast<std::uint16_t>(out_here + out);
      d[i] = static_cast<std::uint16_t>(d[i] & (out - 1));
    }
    outside += out_here;
  }
  return outside;
}

std::uint32_t drop_flagged(std::span<std::uint16_t> depth,
                           std::span<const std::uint8_t> flags) noexcept {
  std::uint32_t dropped = 0;
  for (std::size_t i = 0; i < std::min(depth.size(), flags.size()); ++i) {
    const bool drop = flags[i] != 0 && depth[i] != 0;
    dropped += drop;
    if (drop) depth[i] = 0;
  }
  return dropped;
}

void OutlierFilter::layout(Arena& arena, std::uint32_t max_width,
                           std::uint32_t max_height) noexcept {
  rows_ = arena.take<float>(3 * row_floats(max_width));
  distances_ = arena.take<float>((row_floats(max_width)) * max_height);
  max_width_ = max_width;
}

Status OutlierFilter::process(std::span<const std::uint16_t> depth, std::uint32_t width,
                              std::uint32_t height, const OutlierOptions& options,
                              std::span<std::uint8_t> flags, OutlierCounts& counts) noexcept {
  counts = {};
  if (depth.size() != std::size_t{width} * height || flags.size() != depth.size()) {
    return Status::kWrongSize;
  }
  const std::size_t stride = row_floats(width);
  if (width > max_width_ || stride * height > distances_.size()) return Status::kFrameTooLarge;
  std::fill(rows_.begin(), rows_.end(), 0.0F);
  const auto row = [&](std::uint32_t v) { return rows_.data() + (v % 3) * stride + kBorder; };
  const auto load_row = [&](std::uint32_t v) {
    float* to = row(v);
    const std::uint16_t* from = depth.data() + std::size_t{v} * width;
    std::uint32_t u = 0;
    for (; u + 4 <= width; u += 4) store4(to + u, load4(from + u));
    for (; u < width; ++u) to[u] = from[u];
  };
  if (height > 0) load_row(0);
  for (std::uint32_t v = 0; v < height; ++v) {
    if (v + 1 < height) {
      load_row(v + 1);
    } else {
      std::fill_n(row(v + 1), width, 0.0F);
    }
    measure_row(width, row(v + 2), row(v), row(v + 1), distances_.data() + v * stride);
  }
  double sum = 0, squares = 0;
  std::uint64_t measured = 0;
  for (std::uint32_t v = 0; v < height; ++v) {
    const float* d = distances_.data() + v * stride;
    Float4 s = all4(0), q = all4(0), n = all4(0), all = all4(0);
    for (std::uint32_t u = 0; u < width; u += 4) {  // lanes past the row are holes
      const Float4 value = load4(d + u);
      const Int4 reading = value >= all4(0);
      const Int4 counted = reading & (value < all4(kIsolated));
      const Float4 kept = keep4(counted, value);
      s += kept;
      q += kept * kept;
      n += keep4(counted, all4(1));
      all += keep4(reading, all4(1));
    }
    sum += sum4(s);
    squares += sum4(q);
    measured += static_cast<std::uint64_t>(sum4(n));
    counts.readings += static_cast<std::uint32_t>(sum4(all));
  }
  counts.isolated = counts.readings - static_cast<std::uint32_t>(measured);
  double cut = 0;
  if (measured > 0) {
    const double mean = sum / static_cast<double>(measured);
    const double variance = squares / static_cast<double>(measured) - mean * mean;
    cut = mean + options.deviations * std::sqrt(std::max(0.0, variance));
  }
  // A perfectly even frame has no deviation: rounding must not make outliers of it.
  const auto limit = static_cast<float>(cut * (1 + 1e-5) + 1e-9);
  for (std::uint32_t v = 0; v < height; ++v) {
    const float* d = distances_.data() + v * stride;
    std::uint8_t* out = flags.data() + std::size_t{v} * width;
    std::uint32_t outliers = 0;
    for (std::uint32_t u = 0; u < width; ++u) {
      const std::uint8_t flag = d[u] > limit ? 1 : 0;
      out[u] = flag;
      outliers += flag;
    }
    counts.outliers += outliers;
  }
  return Status::kOk;
}

void OutlierFilter::measure_row(std::uint32_t width, const float* above, const float* here,
                                const float* below, float* out) noexcept {
  for (std::uint32_t u = 0; u < width; u += 4) {
    const Float4 z = load4(here + u);
    const Float4 pairs[4] = {
        min4(difference(z, load4(here + u - 1)), difference(z, load4(here + u + 1))),
        min4(difference(z, load4(above + u)), difference(z, load4(below + u))),
        min4(difference(z, load4(above + u - 1)), difference(z, load4(below + u + 1))),
        min4(difference(z, load4(above + u + 1)), difference(z, load4(below + u - 1)))};
    Float4 sum = all4(0), directions = all4(0);
    for (const Float4& pair : pairs) {
      const Int4 known = pair < all4(kNoNeighbour);
      sum += keep4(known, pair);
      directions += keep4(known, all4(1));
    }
    const Float4 relative = sum / max4(directions * z, all4(1));
    const Float4 measured = directions > all4(0) ? relative : all4(kIsolated);
    store4(out + u, z > all4(0) ? measured : all4(kHole));
  }
}

}  // namespace planecast
