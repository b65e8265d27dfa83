// The prediction of one pixel's level from its decoded neighbours and, where its block lies on a
// surface, from that surface; and the context its correction is coded in. One definition, used by
// both halves. Levels, see level_table.hpp; section numbers refer to docs/wire-format.md, "Pixels".
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>

#include "core/predict/block_surface.hpp"

namespace planecast {

/// What later pixels need of a coded pixel.
struct alignas(8) PixelState {
  std::uint16_t level = 0;          ///< 0: no reading
  std::int8_t correction = 0;       ///< -2 .. 2
  std::uint8_t surface_miss = 0;    ///< |level - surface prediction|, at most kMissCap
  std::uint8_t neighbour_miss = 0;  ///< |level - neighbour prediction|, at most kMissCap
  std::uint8_t choice = 0;  ///< surfaces kind: 0 off, 1 on the block's first, 2 on its second
};

inline constexpr int kMissCap = 100;

/// Causal neighbourhood: l left, u above, ul, ur; ll and uu two away. Outside the tile: empty.
struct Neighbourhood {
  PixelState l, u, ul, ur;
  std::uint16_t ll = 0;
  std::uint16_t uu = 0;
};

inline constexpr int kActivityClasses = 8;
inline constexpr int kCorrectionContexts = 2 * kActivityClasses * 81;
inline constexpr int kSignContexts = 2 * 27;
inline constexpr int kMagnitudeContexts = 2 * kActivityClasses * 3;

/// A prediction with everything its correction is coded by.
struct PixelPrediction {
  std::int32_t level = 1;       ///< the prediction in use
  std::int32_t neighbour = 1;   ///< what the neighbours alone say
  std::int32_t surface = 1;     ///< what the surface with its drift says
  std::int32_t half_width = 0;  ///< levels around `level` within the bound
  std::uint16_t correction_context = 0;
  std::uint8_t sign_context = 0;
  std::uint8_t magnitude_context = 0;

  /// Levels from one correction to the next: windows of neighbouring corrections overlap a
  /// little, so that a reading near the border of one does not flip to and fro.
  std::int32_t step() const noexcept { return half_width + half_width / 2 + 1; }
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

inline int magnitude_class(int correction) noexcept {
  return std::min(std::abs(correction), 2);
}

inline int activity_class(int sum, int half) noexcept {
  while (half > 15) {
    half >>= 1;
    sum >>= 1;
  }
  return kActivity.of[half][std::min(sum, 255)];
}

/// Median of left, above and left + above - above-left; the nearest one there is at borders.
inline std::int32_t neighbour_prediction(const Neighbourhood& n, std::int32_t fallback) noexcept {
  const std::int32_t l = n.l.level, u = n.u.level, ul = n.ul.level, ur = n.ur.level;
  if (l != 0 && u != 0 && ul != 0) {
    return std::clamp(l + u - ul, std::min(l, u), std::max(l, u));
  }
  if (l != 0) return l;
  if (u != 0) return u;
  if (ur != 0) return ur;
  if (ul != 0) return ul;
  if (n.ll != 0) return n.ll;
  if (n.uu != 0) return n.uu;
  return fallback;
}

/// Mean distance of decoded neighbours from the surface, drawn to zero by 0.9, in 1/256 level.
/// Neighbours further than `limit_q8` are not on the surface and do not count.
inline std::int32_t surface_drift_q8(const Neighbourhood& n, std::int32_t at_q8, std::int32_t dx,
                                     std::int32_t dy, std::int32_t limit_q8) noexcept {
  std::int32_t sum = 0;
  int weight = 0;
  const auto add = [&](std::uint16_t level, std::int32_t expected_q8, int w) {
    if (level == 0) return;
    const std::int32_t off = level * 256 - expected_q8;
    if (off > limit_q8 || off < -limit_q8) return;
    sum += off * w;
    weight += w;
  };
  add(n.l.level, at_q8 - dx, 4);
  add(n.u.level, at_q8 - dy, 4);
  add(n.ul.level, at_q8 - dx - dy, 1);
  add(n.ur.level, at_q8 + dx - dy, 2);
  return static_cast<std::int32_t>((std::int64_t{sum} * kDriftScale[weight]) >> 16);
}

}  // namespace detail

/// Predicts a pixel. `surface_q8`: the block's surface at this pixel (dx, dy its slopes), used
/// when has_surface; `half_widths`: of the pixel's ray class; `last_level`: table's highest level;
/// `fallback`: level of the pixel coded last in the tile.
inline PixelPrediction predict_pixel(const Neighbourhood& n, bool has_surface,
                                     std::int32_t surface_q8, std::int32_t dx, std::int32_t dy,
                                     const std::uint8_t* half_widths, std::int32_t last_level,
                                     std::int32_t fallback) noexcept {
  PixelPrediction out;
  out.neighbour = detail::neighbour_prediction(n, fallback);
  out.surface = out.neighbour;
  bool use_surface = false;
  if (has_surface) {
    const std::int32_t at = std::clamp((surface_q8 + 128) >> 8, 1, last_level);
    const std::int32_t reach = half_widths[at];
    const std::int32_t limit_q8 = (12 + 3 * reach) * 256;
    const std::int32_t drift = detail::surface_drift_q8(n, surface_q8, dx, dy, limit_q8);
    out.surface = std::clamp((surface_q8 + drift + 128) >> 8, 1, last_level);
    const int miss_s =
        2 * (n.l.surface_miss + n.u.surface_miss) + n.ul.surface_miss + n.ur.surface_miss;
    const int miss_n =
        2 * (n.l.neighbour_miss + n.u.neighbour_miss) + n.ul.neighbour_miss + n.ur.neighbour_miss;
    const bool no_neighbour = (n.l.level | n.u.level | n.ul.level | n.ur.level) == 0;
    use_surface = no_neighbour || miss_s <= miss_n + 2 * (2 + reach);
  }
  out.level = use_surface ? out.surface : out.neighbour;
  out.half_width = half_widths[out.level];

  const int missing = out.half_width + 3;
  const int l = n.l.level, u = n.u.level, ul = n.ul.level, ur = n.ur.level;
  const int sum = (l != 0 && ul != 0 ? std::abs(l - ul) : missing) +
                  (u != 0 && ul != 0 ? std::abs(u - ul) : missing) +
                  (u != 0 && ur != 0 ? std::abs(u - ur) : missing);
  const int activity = detail::activity_class(sum, out.half_width);
  const int ml = detail::magnitude_class(n.l.correction),
            mu = detail::magnitude_class(n.u.correction);
  const int mul = detail::magnitude_class(n.ul.correction),
            mur = detail::magnitude_class(n.ur.correction);
  const int side = use_surface ? 1 : 0;
  out.correction_context = static_cast<std::uint16_t>((side * kActivityClasses + activity) * 81 +
                                                      ml * 27 + mu * 9 + mul * 3 + mur);
  const int sign_l = (n.l.correction > 0) - (n.l.correction < 0) + 1;
  const int sign_u = (n.u.correction > 0) - (n.u.correction < 0) + 1;
  const int lean = (out.level < l) - (out.level > l) + 1;
  out.sign_context = static_cast<std::uint8_t>(side * 27 + lean * 9 + sign_l * 3 + sign_u);
  const int around = ml + mu > 2 ? 2 : (ml + mu > 0 ? 1 : 0);
  out.magnitude_context =
      static_cast<std::uint8_t>((side * kActivityClasses + activity) * 3 + around);
  return out;
}

/// The state a pixel leaves for its successors.
inline PixelState pixel_state(const PixelPrediction& prediction, std::int32_t level,
                              std::int32_t correction) noexcept {
  PixelState out;
  out.level = static_cast<std::uint16_t>(level);
  out.correction = static_cast<std::int8_t>(std::clamp(correction, -2, 2));
  out.surface_miss =
      static_cast<std::uint8_t>(std::min(std::abs(level - prediction.surface), kMissCap));
  out.neighbour_miss =
      static_cast<std::uint8_t>(std::min(std::abs(level - prediction.neighbour), kMissCap));
  return out;
}

}  // namespace planecast
