// The contexts of a row's "is there a reading" decisions, eight pixels at a time: holes around are
// read as bits once, not pixel by pixel (docs/wire-format.md, "Pixels"). Both halves share it.
#pragma once

#include <array>
#include <cstdint>

#include "core/base/lanes.hpp"
#include "core/predict/pixel_row.hpp"

namespace planecast {

namespace detail {

/// The part of a context that the five pixels above say, by their bits from two left to two right.
struct MaskAbove {
  std::array<std::uint8_t, 32> of{};
  constexpr MaskAbove() {
    for (unsigned bits = 0; bits < 32; ++bits) {
      const unsigned context = (bits >> 2 & 1U) << 1 | (bits >> 1 & 1U) << 2 |
                               (bits >> 3 & 1U) << 3 | (bits >> 4 & 1U) << 6 | (bits & 1U) << 7;
      of[bits] = static_cast<std::uint8_t>(context);
    }
  }
};
inline constexpr MaskAbove kMaskAbove{};

}  // namespace detail

/// Goes along up to eight pixels of a row.
class MaskWalk {
 public:
  /// From the pixel at index `at` of the row on; what is right of it in `here` is not looked at.
  MaskWalk(const PixelRow& here, const PixelRow& above, const PixelRow& above2,
           std::size_t at) noexcept
      : above_(nonzero_bits8(load8(above.level + at - 2)) |
               nonzero_bits8(load8(above.level + at + 2)) << 4U),
        above2_(nonzero_bits8(load8(above2.level + at))),
        before_((here.level[at - 1] != 0 ? 1U : 0U) | (here.level[at - 2] != 0 ? 2U : 0U)) {}

  /// Bits: left, above, above left, above right, two left, two above, above two right and two left.
  std::uint32_t context() const noexcept {
    return (before_ & 1U) | (before_ & 2U) << 3U | detail::kMaskAbove.of[above_ & 31U] |
           (above2_ & 1U) << 5U;
  }
  /// To the next pixel; whether this one is a reading.
  void step(bool reading) noexcept {
    above_ >>= 1U;
    above2_ >>= 1U;
    before_ = before_ << 1U | (reading ? 1U : 0U);
  }

 private:
  unsigned above_, above2_, before_;
};

}  // namespace planecast
