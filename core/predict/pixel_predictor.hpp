// The prediction of one pixel's level from its decoded neighbours and, where its block lies on a
// surface, from that surface; and the context its correction is coded in. One definition, used by
// both halves. Levels, see level_table.hpp; section numbers refer to docs/wire-format.md, "Pixels".
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>

#include "core/predict/block_surface.hpp"
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
  std::int32_t reach = 0;                     ///< half-width at the surface in the block's middle
  std::int32_t limit_q8 = 0;                  ///< neighbours further off are not on the surface
  Int4 above_q8 = {};                         ///< the surface at ul, u and ur
  Int4 limits_q8 = {};                        ///< limit_q8 for these; the fourth never counts
  const std::uint8_t* half_widths = nullptr;  ///< of the pixel's ray class
  std::int32_t last_level = 1;                ///< of the table

  PixelPlace() = default;
  PixelPlace(const std::uint8_t* half_widths_of_class, std::int32_t last) noexcept
      : half_widths(half_widths_of_class), last_level(last) {}

  /// At the first pixel of row y of a block that lies on a surface.
  void lie_on(const BlockSurface& surface, std::uint32_t y) noexcept {
    has_surface = true;
    surface_q8 = surface.at(0, y);
    dx = surface.dx;
    dy = surface.dy;
    const std::int32_t middle = (surface.at(4, 4) + 128) >> 8;
    reach = half_widths[std::clamp(middle, 1, last_level)];
    limit_q8 = (12 + 3 * reach) * 256;
    above_q8 = Int4{surface_q8 - dx - dy, surface_q8 - dy, surface_q8 + dx - dy, 0};
    limits_q8 = Int4{limit_q8, limit_q8, limit_q8, -1};
  }
  /// One pixel to the right.
  void step_right() noexcept {
    surface_q8 += dx;
    above_q8 += Int4{dx, dx, dx, 0};
  }
};

namespace detail {

/// Activity class by sum of neighbour differences, for half-widths 0..15 (greater ones scaled).
/// Computed when the program starts, in tables.cpp: 4 kB that a board's flash need not hold.
struct ActivityTable {
  std::array<std::array<std::uint8_t, 256>, 16> of{};
  ActivityTable() noexcept {
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
extern const ActivityTable kActivity;

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

/// The lesser of two levels, without a branch: which one it is no processor could guess.
inline std::int32_t lesser(std::int32_t a, std::int32_t b) noexcept {
  const std::int32_t less = a - b;
  return b + (less & (less >> 31));
}

/// Median of left, above and left + above - above-left; where one is missing, the nearest one
/// there is.
[[gnu::always_inline]] inline std::int32_t neighbour_prediction(const Neighbourhood& n,
                                                                std::int32_t fallback) noexcept {
  const std::int32_t l = n.l(), u = n.u(), ul = n.ul();
  if (l != 0 && u != 0 && ul != 0) {
    const std::int32_t low = lesser(l, u), high = l + u - low;
    const std::int32_t capped = lesser(l + u - ul, high);
    return low + capped - lesser(low, capped);
  }
  for (const std::int32_t level : {l, u, n.ur(), ul, n.ll(), n.uu()}) {
    if (level != 0) return level;
  }
  return fallback;
}

/// Weighted mean distance of decoded neighbours from the surface, drawn to zero by 0.9, in 1/256
/// level. Neighbours further off than the place's limit are not on the surface and do not count.
[[gnu::always_inline]] inline std::int32_t surface_drift_q8(const Neighbourhood& n,
                                                            const PixelPlace& place) noexcept {
  const Int4 levels = n.row_above();
  Int4 off = levels * 256 - place.above_q8;
  const Int4 counts = (levels != 0) & (off <= place.limits_q8) & (off >= -place.limits_q8);
  off &= counts;
  const std::int32_t l = n.l();
  const std::int32_t off_l = l * 256 - (place.surface_q8 - place.dx);
  const bool l_counts = (l != 0) & (off_l <= place.limit_q8) & (off_l >= -place.limit_q8);
  const std::int32_t sum = off[0] + 4 * (off[1] + (l_counts ? off_l : 0)) + 2 * off[2];
  const unsigned set = lane_bits(counts) | (l_counts ? 8U : 0U);
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

/// Predicts a pixel of which its neighbours alone say `neighbour`.
[[gnu::always_inline]] inline PixelPrediction predict_from(const Neighbourhood& n,
                                                           const PixelPlace& place,
                                                           std::int32_t neighbour) noexcept {
  PixelPrediction out;
  out.neighbour = neighbour;
  out.surface = out.neighbour;
  if (place.has_surface) {
    const std::int32_t at_q8 = place.surface_q8 + detail::surface_drift_q8(n, place);
    out.surface = std::clamp((at_q8 + 128) >> 8, 1, place.last_level);
    const std::uint32_t misses = n.misses();
    const auto slack = static_cast<std::uint32_t>(2 * (2 + place.reach));
    // Without neighbours nothing was missed, which the comparison grants to the surface.
    out.by_surface = (misses >> 16U) <= (misses & 0xffffU) + slack;
  }
  // Without a branch, as above.
  out.level = out.neighbour ^ ((out.surface ^ out.neighbour) & -std::int32_t{out.by_surface});
  out.half_width = place.half_widths[out.level];
  return out;
}

/// Predicts a pixel. `fallback`: level of the pixel coded last in the tile.
[[gnu::always_inline]] inline PixelPrediction predict_pixel(const Neighbourhood& n,
                                                            const PixelPlace& place,
                                                            std::int32_t fallback) noexcept {
  return predict_from(n, place, detail::neighbour_prediction(n, fallback));
}

/// Class of the neighbours' differences, apart for the two predictions: 0..2 kActivityClasses - 1.
[[gnu::always_inline]] inline int pixel_activity(const Neighbourhood& n,
                                                 const PixelPrediction& p) noexcept {
  return detail::activity_class(detail::activity_sum(n, p.half_width), p.half_width) +
         (p.by_surface ? kActivityClasses : 0);
}

/// Context of "is there a correction".
[[gnu::always_inline]] inline std::uint16_t correction_context(const Neighbourhood& n,
                                                               int activity) noexcept {
  return static_cast<std::uint16_t>(static_cast<std::uint32_t>(activity) * 81 + n.sizes());
}

/// Context of a correction's sign.
inline std::uint8_t sign_context(const Neighbourhood& n, const PixelPrediction& p) noexcept {
  const std::int32_t l = n.l();
  const int tilt = (p.level < l) - (p.level > l);
  return static_cast<std::uint8_t>((p.by_surface ? 27 : 0) + tilt * 9 +
                                   n.here.past[n.at - 1].lean * 3 + n.above.past[n.at].lean + 13);
}

/// Context of a correction's magnitude.
inline std::uint8_t magnitude_context(const Neighbourhood& n, int activity) noexcept {
  const int around = std::min(n.here.past[n.at - 1].size + n.above.past[n.at].size, 3);
  return static_cast<std::uint8_t>(activity * 3 + (around + 1) / 2);
}

/// Leaves what later pixels need of a pixel at index `at` of its row that took its prediction.
[[gnu::always_inline]] inline void keep_predicted(PixelRow& row, std::size_t at,
                                                  const PixelPrediction& p) noexcept {
  row.level[at] = static_cast<std::uint16_t>(p.level);
  const auto apart =
      static_cast<std::uint32_t>(std::min(std::abs(p.surface - p.neighbour), kMissCap));
  row.past[at] = {apart << (p.by_surface ? 0U : 16U), 0, 0, 0};
}

/// The same of a pixel with a correction.
inline void keep_corrected(PixelRow& row, std::size_t at, const PixelPrediction& p,
                           std::int32_t level, std::int32_t correction) noexcept {
  const auto miss = [&](std::int32_t predicted) {
    return static_cast<std::uint32_t>(std::min(std::abs(level - predicted), kMissCap));
  };
  row.level[at] = static_cast<std::uint16_t>(level);
  row.past[at] = {miss(p.surface) << 16U | miss(p.neighbour),
                  static_cast<std::uint8_t>(std::abs(correction) > 1 ? 2 : 1),
                  static_cast<std::int8_t>(correction > 0 ? 1 : -1), 0};
}

/// The same of a pixel that lies on a surface without a correction (surfaces kind).
inline void keep_chosen(PixelRow& row, std::size_t at, std::int32_t level,
                        std::uint8_t choice) noexcept {
  row.level[at] = static_cast<std::uint16_t>(level);
  row.past[at] = {0, 0, 0, choice};
}

}  // namespace planecast
