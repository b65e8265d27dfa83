// Contexts of the mixed decisions of a pixel (docs/wire-format.md, "Mixed tile"). Both halves.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstdlib>

#include "core/predict/blend_predictor.hpp"
#include "core/wire/mix_models.hpp"

namespace planecast {

/// Where each input's models lie and which mixer weighs them.
struct PixelContexts {
  std::int32_t of[kPixelInputs];
  int mixer;
  bool mirrored;  ///< signs are turned round, so that the fraction of the prediction is positive
};

namespace detail {

inline int limited(std::int32_t d, int most) noexcept {
  return std::clamp<std::int32_t>(d, -most, most) + most;
}
/// -3 .. 3 of a difference: 1, 2, 3 to 4 as two, more.
inline int graded(std::int32_t d) noexcept {
  const std::int32_t size = std::abs(d);
  const int grade = size < 2 ? size : (size < 4 ? 2 : 3);
  return (d < 0 ? -grade : grade) + 3;
}
inline int log_class(std::int32_t sum, int most) noexcept {
  // 0 1 2 3 4-5 6-7 8-11 12-15 ...
  if (sum < 4) return std::min<int>(sum, most);
  const int length = std::bit_width(static_cast<std::uint32_t>(sum));
  return std::min<int>(2 * length - 2 + ((sum >> (length - 2)) & 1), most);
}

}  // namespace detail

inline PixelContexts pixel_contexts(const BlendAround& n, const BlendLevels& p,
                                    const BlendedPixel& x, bool on_surface) noexcept {
  using detail::graded;
  using detail::limited;
  PixelContexts out;
  const std::int32_t step = x.step();
  const std::int32_t fraction = x.level_q8 - 256 * x.level;
  out.mirrored = fraction < 0;
  const std::int32_t side = out.mirrored ? -1 : 1;
  // In steps, by a rounded reciprocal.
  const std::int32_t inverse = 65536 / step;
  const auto away = [&](std::int32_t level) {
    return (std::clamp(level - x.level, -4096, 4096) * side * inverse + 32768) >> 16;
  };
  const auto away_q2 = [&](std::int32_t level_q2) {
    return (std::clamp(level_q2 - 4 * x.level, -16384, 16384) * side * (inverse / 4) + 32768) >> 16;
  };
  const std::int32_t el = side * n.here.error[n.at - 1], eu = side * n.above.error[n.at];
  const std::int32_t eul = side * n.above.error[n.at - 1], eur = side * n.above.error[n.at + 1];
  const std::int32_t ell = side * n.here.error[n.at - 2], euu = side * n.above2.error[n.at];
  const std::int32_t errors = 2 * (std::abs(el) + std::abs(eu)) + std::abs(eul) + std::abs(eur) +
                              std::abs(ell) + std::abs(euu);
  const std::int32_t slopes = std::abs(p.l - p.ul) + std::abs(p.u - p.ul) + std::abs(p.u - p.ur);
  const std::int32_t gradients = (std::min(slopes, 16383) * inverse) >> 16;
  const int by_error = detail::log_class(errors, 11);
  const int by_gradient = detail::log_class(gradients, 7);
  const int fine = std::min(std::abs(fraction) >> 4, 7);
  const auto size = [](std::int32_t e) { return std::min(std::abs(e), 2); };
  const std::int32_t l = away(p.l), u = away(p.u), ur = away(p.ur);
  int c[kPixelInputs];
  c[0] = by_error * 8 + by_gradient;
  c[1] = fine * 12 + detail::log_class(x.off, 11);
  c[2] = (graded(l) * 7 + graded(u)) * 3 + limited(ur, 1);
  c[3] = ((limited(el, 2) * 5 + limited(eu, 2)) * 3 + limited(eul, 1)) * 3 + limited(eur, 1);
  c[4] = (limited(away_q2(x.candidates[0]), 2) * 5 + limited(away_q2(x.candidates[1]), 2)) * 6 +
         (on_surface ? limited(away_q2(x.candidates[7]), 2) : 5);
  c[5] = (p.l == p.ul) | (p.u == p.ul) << 1 | (p.u == p.ur) << 2 | (p.l == p.ll) << 3 |
         (p.u == p.uu) << 4 | (p.l == p.u) << 5 | (x.level == p.l) << 6;
  c[6] = ((((size(el) * 3 + size(eu)) * 3 + size(eul)) * 3 + size(eur)) * 3 + size(ell)) * 3 +
         size(euu);
  c[7] = (limited(away(2 * p.l - p.ll), 2) * 5 + limited(away(2 * p.u - p.uu), 2)) * 5 +
         limited(away(p.l + p.ur - p.u), 2);
  int first = 0;
  for (std::size_t i = 0; i < kPixelInputs; ++i) {
    out.of[i] = first + c[i];
    first += kPixelContexts[i];
  }
  out.mixer = by_error;
  return out;
}

/// Where the models of a pixel's hole decision lie.
struct MaskContexts {
  std::int32_t of[kMaskInputs];
  int mixer;
};

/// `x` is the pixel's column within the tile; `right` what is known of the block to the right: 0
/// all holes, 1 some, 3 none, 2 outside the tile.
inline MaskContexts mask_contexts(const BlendAround& n, std::uint32_t x, int right) noexcept {
  const auto h = [&](int dx) { return n.here.level[n.at + dx] != 0 ? 1 : 0; };
  const auto a = [&](int dx) { return n.above.level[n.at + dx] != 0 ? 1 : 0; };
  const auto b = [&](int dx) { return n.above2.level[n.at + dx] != 0 ? 1 : 0; };
  const int near =
      h(-1) | a(0) << 1 | a(-1) << 2 | a(1) << 3 | h(-2) << 4 | b(0) << 5 | a(2) << 6 | a(-2) << 7;
  const int wide = near | h(-3) << 8 | b(-1) << 9 | b(1) << 10 | a(3) << 11;
  int run = 1;
  while (run < 15 && run < static_cast<int>(n.at) &&
         (n.here.level[n.at - 1 - run] != 0) == (h(-1) != 0))
    ++run;
  // How far right the row above stays as it is above this pixel.
  int ahead = 1;
  while (ahead < 4 && a(ahead) == a(0)) ++ahead;
  int behind = 1;
  while (behind < 4 && a(-behind) == a(0)) ++behind;
  MaskContexts out;
  int first = 0;
  const int c[kMaskInputs] = {
      near, wide, (run * 4 + (ahead - 1)) * 4 + h(-1) * 2 + a(0),
      static_cast<int>((x & 7U) * 128) + (near & 15) * 4 + right + 64 * b(0),
      ((behind - 1) * 4 + (ahead - 1)) * 32 +
          (h(-1) | a(0) << 1 | b(0) << 2 | b(-1) << 3 | b(1) << 4)};
  for (std::size_t i = 0; i < kMaskInputs; ++i) {
    out.of[i] = first + c[i];
    first += kMaskInputContexts[i];
  }
  out.mixer = near & 15;
  return out;
}

}  // namespace planecast
