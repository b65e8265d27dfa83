// The prediction of one pixel's level from its decoded neighbours and, where its block lies on a
// surface, from that surface; and the context its correction is coded in. One definition, used by
// both halves. Levels, see level_table.hpp; section numbers refer to docs/wire-format.md, "Pixels".
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>

#include "core/predict/pixel_row.hpp"

namespace planecast {

inline constexpr int kActivityClasses = 8;
inline constexpr int kCorrectionContexts = 2 * kActivityClasses * 81;
inline constexpr int kSignContexts = 2 * 27;
inline constexpr int kMagnitudeContexts = 2 * kActivityClasses * 3;

/// A prediction of one pixel.
struct PixelPrediction {
  std::int32_t level = 1;       ///< the prediction in use
  std::int32_t neighbour = 1;   ///< what the neighbours alone say
  std::int32_t surface = 1;     ///< what the surface with its drift says
  std::int32_t half_width = 0;  ///< levels around `level` within the bound
  bool by_surface = false;      ///< the surface's is in use

  /// Levels from one correction to the next: windows of neighbouring corrections overlap a
  /// little, so that a reading near the border of one does not flip to and fro.
  std::int32_t step() const noexcept { return half_width + half_width / 2 + 1; }
};

/// Where a pixel's prediction comes from beside its neighbours.
struct PixelPlace {
  bool has_surface = false;                   ///< its block lies on a surface
  std::int32_t surface_q8 = 0;                ///< that surface at the pixel, in 1/256 level
  std::int32_t dx = 0, dy = 0;                ///< its slopes
  Int4 above_q8 = {};                         ///< the surface at ul, u and ur
  const std::uint8_t* half_widths = nullptr;  ///< of the pixel's ray class
  std::int32_t last_level = 1;                ///< of the table

  PixelPlace() = default;
  PixelPlace(const std::uint8_t* half_widths_of_class, std::int32_t last) noexcept
      : half_widths(half_widths_of_class), last_level(last) {}
  /// On a surface of the given slopes.
  void lie_on(std::int32_t at_q8, std::int32_t slope_x, std::int32_t slope_y) noexcept {
    has_surface = true;
    surface_q8 = at_q8;
    dx = slope_x;
    dy = slope_y;
    above_q8 = Int4{at_q8 - dx - dy, at_q8 - dy, at_q8 + dx - dy, 0};
  }
  /// One pixel to the right.
  void step_right() noexcept {
    surface_q8 += dx;
    above_q8 += Int4{dx, dx, dx, 0};
  }
};

namespace detail {

/// Activity class by sum of neighbour differences, for half-widths 0..15 (greater ones scaled).
struct ActivityTable {
  std::array<std::array<std::uint8_t, 256>, 16> of{};
  constexpr ActivityTable() {
    for (int half = 0; half < 16; ++half) {
      for (int sum = 0; sum < 256; ++sum) of[half][sum] = classify(sum, half);
    }
  }
  static constexpr std::uint8_t classify(int sum, int half) {
    if (sum == 0) return 0;
    constexpr int kLossless[6] = {1, 2, 4, 7, 12, 25};
    constexpr int kBounded[6] = {1, 2, 3, 5, 8, 16};
    for (int c = 0; c < 6; ++c) {
      if (sum <= (half == 0 ? kLossless[c] : kBounded[c] * half))
        return static_cast<std::uint8_t>(c + 1);
    }
    return 7;
  }
};
inline constexpr ActivityTable kActivity{};

/// 0.9 / weight in Q16 for weight sums 0..11 (l 4, u 4, ur 2, ul 1).
inline constexpr std::array<std::int32_t, 12> kDriftScale = {
    0, 58982, 29491, 19661, 14746, 11796, 9830, 8426, 7373, 6554, 5898, 5362};

/// The same by the set of neighbours that count: ul 1, u 2, ur 4, l 8.
struct DriftTable {
  std::array<std::int32_t, 16> of{};
  constexpr DriftTable() {
    for (unsigned set = 0; set < 16; ++set) {
      of[set] = kDriftScale[(set & 1U) + (set & 2U) * 2 + (set & 4U) / 2 + (set & 8U) / 2];
    }
  }
};
inline constexpr DriftTable kDrift{};

inline int activity_class(int sum, int half) noexcept {
  while (half > 15) {
    half >>= 1;
    sum >>= 1;
  }
  return kActivity.of[half][std::min(sum, 255)];
}

/// Median of left, above and left + above - above-left; where one is missing, the nearest one
/// there is.
[[gnu::always_inline]] inline std::int32_t neighbour_prediction(const Neighbourhood& n,
                                                                std::int32_t fallback) noexcept {
  const std::int32_t l = n.l(), u = n.u(), ul = n.ul();
  if (l != 0 && u != 0 && ul != 0) {
    return std::clamp(l + u - ul, std::min(l, u), std::max(l, u));
  }
  for (const std::int32_t level : {l, u, n.ur(), ul, n.ll(), n.uu()}) {
    if (level != 0) return level;
  }
  return fallback;
}

/// Weighted mean distance of decoded neighbours from the surface, drawn to zero by 0.9, in 1/256
/// level. Neighbours further than `limit_q8` are not on the surface and do not count.
[[gnu::always_inline]] inline std::int32_t surface_drift_q8(const Neighbourhood& n,
                                                            const PixelPlace& place,
                                                            std::int32_t limit_q8) noexcept {
  const Int4 levels = n.row_above();
  Int4 off = levels * 256 - place.above_q8;
  const Int4 limit = {limit_q8, limit_q8, limit_q8, -1};  // the fourth never counts
  const Int4 counts = (levels != 0) & (off <= limit) & (off >= -limit);
  off &= counts;
  const std::int32_t l = n.l();
  const std::int32_t off_l = l * 256 - (place.surface_q8 - place.dx);
  const bool l_counts = (l != 0) & (off_l <= limit_q8) & (off_l >= -limit_q8);
  const std::int32_t sum = off[0] + 4 * (off[1] + (l_counts ? off_l : 0)) + 2 * off[2];
  const int set = (counts[0] & 1) | (counts[1] & 2) | (counts[2] & 4) | (l_counts ? 8 : 0);
  return static_cast<std::int32_t>((std::int64_t{sum} * kDrift.of[set]) >> 16);
}

/// Sum of the differences between neighbours; a missing one counts as a little over the bound.
[[gnu::always_inline]] inline std::int32_t activity_sum(const Neighbourhood& n,
                                                        std::int32_t half_width) noexcept {
  const std::int32_t l = n.l(), u = n.u(), ul = n.ul(), ur = n.ur();
  if (l != 0 && u != 0 && ul != 0 && ur != 0) {
    return std::abs(l - ul) + std::abs(u - ul) + std::abs(u - ur);
  }
  const std::int32_t missing = half_width + 3;
  return (l != 0 && ul != 0 ? std::abs(l - ul) : missing) +
         (u != 0 && ul != 0 ? std::abs(u - ul) : missing) +
         (u != 0 && ur != 0 ? std::abs(u - ur) : missing);
}

}  // namespace detail

/// Predicts a pixel. `fallback`: level of the pixel coded last in the tile.
[[gnu::always_inline]] inline PixelPrediction predict_pixel(const Neighbourhood& n,
                                                            const PixelPlace& place,
                                                            std::int32_t fallback) noexcept {
  PixelPrediction out;
  out.neighbour = detail::neighbour_prediction(n, fallback);
  out.surface = out.neighbour;
  if (place.has_surface) {
    const std::int32_t at = std::clamp((place.surface_q8 + 128) >> 8, 1, place.last_level);
    const std::int32_t reach = place.half_widths[at];
    const std::int32_t drift = detail::surface_drift_q8(n, place, (12 + 3 * reach) * 256);
    out.surface = std::clamp((place.surface_q8 + drift + 128) >> 8, 1, place.last_level);
    const std::uint32_t misses = n.misses();
    const auto slack = static_cast<std::uint32_t>(2 * (2 + reach));
    // Without neighbours nothing was missed, which the comparison grants to the surface.
    out.by_surface = (misses >> 16U) <= (misses & 0xffffU) + slack;
  }
  out.level = out.by_surface ? out.surface : out.neighbour;
  out.half_width = place.half_widths[out.level];
  return out;
}

/// The contexts in which a pixel's correction is coded.
struct PixelContexts {
  std::uint16_t correction = 0;  ///< of "is there one"
  std::uint8_t sign = 0;
  std::uint8_t magnitude = 0;
};

[[gnu::always_inline]] inline PixelContexts pixel_contexts(const Neighbourhood& n,
                                                           const PixelPrediction& p) noexcept {
  const std::int32_t sum = detail::activity_sum(n, p.half_width);
  const int activity =
      detail::activity_class(sum, p.half_width) + (p.by_surface ? kActivityClasses : 0);
  const std::int32_t l = n.l();
  const int tilt = (p.level < l) - (p.level > l);
  const int sign =
      (p.by_surface ? 27 : 0) + tilt * 9 + n.here.lean[n.at - 1] * 3 + n.above.lean[n.at] + 13;
  const int around = std::min(n.here.size[n.at - 1] + n.above.size[n.at], 3);
  return {static_cast<std::uint16_t>(static_cast<std::uint32_t>(activity) * 81 + n.sizes()),
          static_cast<std::uint8_t>(sign),
          static_cast<std::uint8_t>(activity * 3 + (around + 1) / 2)};
}

/// Leaves what later pixels need of a predicted pixel at index `at` of its row.
[[gnu::always_inline]] inline void keep_pixel(PixelRow& row, std::size_t at,
                                              const PixelPrediction& p, std::int32_t level,
                                              std::int32_t correction) noexcept {
  const auto miss = [&](std::int32_t predicted) {
    return static_cast<std::uint32_t>(std::min(std::abs(level - predicted), kMissCap));
  };
  row.level[at] = static_cast<std::uint16_t>(level);
  row.size[at] = static_cast<std::uint8_t>(std::min(std::abs(correction), 2));
  row.lean[at] = static_cast<std::int8_t>((correction > 0) - (correction < 0));
  row.choice[at] = 0;
  row.misses[at] = miss(p.surface) << 16U | miss(p.neighbour);
}

/// The same of a pixel that lies on a surface without a correction (surfaces kind).
inline void keep_chosen(PixelRow& row, std::size_t at, std::int32_t level,
                        std::uint8_t choice) noexcept {
  row.level[at] = static_cast<std::uint16_t>(level);
  row.size[at] = 0;
  row.lean[at] = 0;
  row.choice[at] = choice;
  row.misses[at] = 0;
}

}  // namespace planecast
