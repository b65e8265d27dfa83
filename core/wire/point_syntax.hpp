// The parts of a point slice that both halves share (docs/wire-format.md, "Point tile").
#pragma once

#include <array>
#include <bit>
#include <cstdint>

#include "core/base/status.hpp"
#include "core/wire/point_cells.hpp"

namespace planecast {

/// The box of cells of a slice of plain numbers: its least corner, and bits of each coordinate.
struct CellBox {
  std::array<std::uint32_t, 3> least{};
  std::array<std::uint32_t, 3> bits{};  ///< 0 .. 32

  std::uint32_t point_bits() const noexcept { return bits[0] + bits[1] + bits[2]; }
};

/// kind, number of points, corner, widths: bits before the first point of a plain slice.
inline constexpr std::uint32_t kPlainHeadBits = 2 + 32 + 3 * 32 + 3 * 6;

/// One number of `bits` bits, at most 32, as raw bits from the top, 16 at a time.
template <class Io>
std::uint32_t plain_number(Io& io, std::uint32_t value, std::uint32_t bits) noexcept {
  std::uint32_t result = 0;
  if (bits > 16) {
    result = io.raw(value >> 16U, static_cast<int>(bits) - 16) << 16U;
    bits = 16;
  }
  if (bits > 0) result |= io.raw(value & ((1U << bits) - 1), static_cast<int>(bits));
  return result;
}

/// Corner and widths. kFieldRange: a width over 32, or a box that leaves the numbers.
template <class Io>
Status plain_box(Io& io, CellBox& box) noexcept {
  for (std::size_t i = 0; i < 3; ++i) {
    box.least[i] = plain_number(io, box.least[i], 32);
    box.bits[i] = io.raw(box.bits[i], 6);
    if (box.bits[i] > 32) return Status::kFieldRange;
  }
  return Status::kOk;
}

}  // namespace planecast
