// The prediction of `--effort best`: eight simple predictions of a pixel's level, blended by how
// far off each was around the pixel, and freed of the error that pixels like it had on average.
// Integers; one definition for both halves (docs/wire-format.md, "Blended prediction").
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>

#include "core/predict/block_surface.hpp"
#include "core/predict/pixel_row.hpp"

namespace planecast {

inline constexpr int kBlended = 8;

/// One row of a tile; pixel x lies at index x + kBorder, and what lies outside reads as a hole.
struct BlendRow {
  static constexpr std::uint32_t kBorder = 4;
  static constexpr std::size_t kSize = kMaxTileSide + 2 * kBorder;

  std::uint16_t level[kSize] = {};            ///< 0: no reading
  std::int8_t error[kSize] = {};              ///< its correction in steps, -100 .. 100
  std::uint8_t choice[kSize] = {};            ///< surfaces kind: as PixelPast::choice
  std::uint8_t misses[kSize][kBlended] = {};  ///< how far off each prediction was, up to 255

  /// Makes pixels x0 .. x1-1 holes.
  void clear(std::uint32_t x0, std::uint32_t x1) noexcept {
    for (std::uint32_t i = kBorder + x0; i < kBorder + x1; ++i) set(i, 0);
  }
  /// A hole, or a reading that nothing was to be said of.
  void set(std::size_t at, std::uint16_t new_level, std::uint8_t new_choice = 0) noexcept {
    level[at] = new_level;
    error[at] = 0;
    choice[at] = new_choice;
    std::memset(misses[at], 0, sizeof misses[at]);
  }
};

/// Three rows around the pixel at index `at`.
struct BlendAround {
  const BlendRow& here;
  const BlendRow& above;
  const BlendRow& above2;
  std::size_t at;
};

/// The neighbours' levels, a missing one replaced by the likeliest there is.
struct BlendLevels {
  std::int32_t l, u, ul, ur, ll, uu;

  BlendLevels(const BlendAround& n, std::int32_t fallback) noexcept
      : l(n.here.level[n.at - 1]),
        u(n.above.level[n.at]),
        ul(n.above.level[n.at - 1]),
        ur(n.above.level[n.at + 1]),
        ll(n.here.level[n.at - 2]),
        uu(n.above2.level[n.at]) {
    if (l == 0 || u == 0) {
      const std::int32_t first = l != 0    ? l
                                 : u != 0  ? u
                                 : ur != 0 ? ur
                                 : ul != 0 ? ul
                                 : ll != 0 ? ll
                                 : uu != 0 ? uu
                                           : fallback;
      if (l == 0) l = first;
      if (u == 0) u = first;
    }
    if (ul == 0) ul = u;
    if (ur == 0) ur = u;
    if (ll == 0) ll = l;
    if (uu == 0) uu = u;
  }
};

namespace detail {

/// Weight of a prediction by the sum of its misses: as the inverse square. Computed when the
/// program starts, in tables.cpp: 8 kB that a board's flash need not hold.
struct BlendWeights {
  std::array<std::uint32_t, 2048> of{};
  BlendWeights() noexcept {
    for (std::uint32_t sum = 0; sum < of.size(); ++sum)
      of[sum] = (std::uint32_t{1} << 24U) / ((sum + 4) * (sum + 4));
  }
};
extern const BlendWeights kBlendWeights;

}  // namespace detail

/// A blended prediction.
struct BlendedPixel {
  std::int32_t level = 1;       ///< nearest level
  std::int32_t level_q8 = 256;  ///< before rounding
  std::int32_t half_width = 0;
  std::int32_t off = 0;                    ///< weighted misses around, in 1/4 levels
  std::int32_t candidates[kBlended] = {};  ///< 1/4 level
  int bias = 0;                            ///< number of the bias that was taken off
  std::int32_t unbiased_q8 = 256;

  std::int32_t step() const noexcept { return half_width + half_width / 2 + 1; }
};

inline constexpr int kBlendBiases = 512;

/// What pixels of one kind missed on average, 1/256 level.
using BlendBiases = std::array<std::int32_t, kBlendBiases>;

/// Predicts from `levels`; `surface_q8` is the block's surface drawn to its neighbours, or 0.
inline BlendedPixel blend_pixel(const BlendAround& n, const BlendLevels& p, std::int32_t surface_q8,
                                const BlendBiases& biases, const std::uint8_t* half_widths,
                                std::int32_t last_level) noexcept {
  BlendedPixel out;
  std::int32_t* c = out.candidates;
  const std::int32_t low = std::min(p.l, p.u), high = std::max(p.l, p.u);
  c[0] = 4 * std::clamp(p.l + p.u - p.ul, low, high);
  c[1] = 4 * (p.l + p.u - p.ul);
  c[2] = 4 * p.l;
  c[3] = 4 * p.u;
  c[4] = 2 * (p.l + p.u) + p.ur - p.ul;
  c[5] = 4 * (p.l + p.ur - p.u);
  c[6] = 4 * (2 * p.u - p.uu);
  c[7] = surface_q8 != 0 ? surface_q8 >> 6 : p.l + p.u + p.ur + p.ul;
  std::int64_t sum = 0, weights = 0;
  std::int32_t least = 1 << 20;
  for (int i = 0; i < kBlended; ++i) {
    const std::int32_t missed = 2 * (n.here.misses[n.at - 1][i] + n.above.misses[n.at][i]) +
                                n.above.misses[n.at - 1][i] + n.above.misses[n.at + 1][i];
    const std::int64_t w = detail::kBlendWeights.of[static_cast<std::size_t>(missed)];
    weights += w;
    sum += w * c[i];
    least = std::min(least, missed);
  }
  out.off = least;
  const std::int32_t blended = static_cast<std::int32_t>((sum * 64) / weights);
  out.unbiased_q8 = std::clamp(blended, 256, 256 * last_level);
  const std::int32_t at = out.unbiased_q8;
  out.bias = (p.l * 256 > at) | (p.u * 256 > at) << 1 | (p.ul * 256 > at) << 2 |
             (p.ur * 256 > at) << 3 | ((2 * p.l - p.ll) * 256 > at) << 4 |
             ((2 * p.u - p.uu) * 256 > at) << 5 |
             std::min<int>(std::bit_width(static_cast<std::uint32_t>(least)) / 2, 3) << 6;
  out.level_q8 =
      std::clamp(at + (biases[static_cast<std::size_t>(out.bias)] >> 8), 256, 256 * last_level);
  out.level = (out.level_q8 + 128) >> 8;
  out.half_width = half_widths[out.level];
  return out;
}

/// Leaves what later pixels need: a reading of `level` that was `error` steps off.
inline void keep_blended(BlendRow& row, std::size_t at, const BlendedPixel& p, BlendBiases& biases,
                         std::int32_t level, std::int32_t error) noexcept {
  row.level[at] = static_cast<std::uint16_t>(level);
  row.error[at] = static_cast<std::int8_t>(std::clamp(error, -100, 100));
  row.choice[at] = 0;
  const int shift = std::bit_width(static_cast<std::uint32_t>(p.step())) - 1;
  for (int i = 0; i < kBlended; ++i) {
    row.misses[at][i] =
        static_cast<std::uint8_t>(std::min(std::abs(4 * level - p.candidates[i]) >> shift, 255));
  }
  std::int32_t& bias = biases[static_cast<std::size_t>(p.bias)];
  const std::int32_t reach = 1024 * p.step();
  const std::int32_t missed = std::clamp(level * 256 - p.unbiased_q8, -reach, reach);
  bias += (missed * 256 - bias) / 64;
}

}  // namespace planecast
