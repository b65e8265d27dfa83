// How a frame is cut into columns of tiles: a tile takes as many rows of blocks as fill its slice,
// so a column of its own width is all there is to choose. Encoder half.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "core/wire/tile_syntax.hpp"

namespace planecast {

/// Columns of blocks; column i goes from `start[i]` to `start[i + 1]`.
struct ColumnPlan {
  static constexpr std::uint32_t kMost = 256;
  std::array<std::uint16_t, kMost + 1> start{};
  std::uint32_t count = 0;

  std::uint32_t width(std::uint32_t i) const noexcept { return start[i + 1] - start[i]; }
};

namespace detail {

/// Slices that `bits` take, a little more than estimated, at `slice_bits` each.
inline double slices_for(double bits, double slice_bits) noexcept {
  constexpr double kDoubt = 1.02;
  return std::max(1.0, std::ceil(bits * kDoubt / slice_bits));
}

}  // namespace detail

/// Cuts `wide` x `high` blocks into columns whose tiles are near square and whose last slices are
/// full. `bits(x0, x1)` estimates what columns x0 .. x1-1 of blocks take, `slice_bits` fill a
/// slice.
template <class Bits>
void plan_columns(std::uint32_t wide, std::uint32_t high, double slice_bits, const Bits& bits,
                  ColumnPlan& plan) noexcept {
  const double slices = bits(0U, wide) / slice_bits;
  const std::uint32_t least = (wide + kMaxTileBlocks - 1) / kMaxTileBlocks;
  const double square = std::round(std::sqrt(slices * wide / high));
  const auto columns = static_cast<std::uint32_t>(
      std::clamp(square, double(least), double(std::min(wide, ColumnPlan::kMost))));
  plan.count = columns;
  plan.start[0] = 0;
  for (std::uint32_t c = 0; c < columns; ++c) {
    const std::uint32_t from = plan.start[c], left = columns - c;
    std::uint32_t to = wide;
    if (left > 1) {
      // Of the widths near an equal share, that whose slices hold most, with the rest's where the
      // rest is one column.
      const double share = bits(from, wide) / left;
      const std::uint32_t last = std::min(wide - (left - 1), from + kMaxTileBlocks);
      std::uint32_t first = from + 1;
      if (wide - first > (left - 1) * kMaxTileBlocks) first = wide - (left - 1) * kMaxTileBlocks;
      double best = 1e300;
      to = first;
      for (std::uint32_t x = first; x <= last; ++x) {
        const double own = bits(from, x);
        const double off = share > 0 ? std::abs(own - share) / share
                                     : std::abs(x - from - double(wide - from) / left) / wide;
        double cost = detail::slices_for(own, slice_bits) * slice_bits / std::max(own, 1.0);
        if (left == 2) {
          const double rest = bits(x, wide);
          cost = (detail::slices_for(own, slice_bits) + detail::slices_for(rest, slice_bits)) *
                 slice_bits / std::max(own + rest, 1.0);
        }
        // A slice in ten costs what tiles of 3 to 2 do.
        cost = std::min(cost, 8.0) + 0.5 * off * off + (off > 0.35 ? off : 0.0);
        if (cost < best) {
          best = cost;
          to = x;
        }
        if (own > 2 * share && share > 0) break;
      }
    }
    plan.start[c + 1] = static_cast<std::uint16_t>(to);
  }
}

}  // namespace planecast
