// The head of a point slice, and slices of plain numbers; both halves (docs/wire-format.md,
// "Point tile").
#pragma once

#include <array>
#include <bit>
#include <cstdint>

#include "core/base/status.hpp"
#include "core/wire/point_cells.hpp"

namespace planecast {

/// What every slice of points says first, behind its kind.
struct PointHead {
  std::uint32_t points = 0;
  std::array<bool, 3> own_pitch{};  ///< not that of the tolerance's cube
  CellAxes axes;
};

/// Bits before the first point of a slice at most: kind, head, widths or tree.
inline constexpr std::uint32_t kPointHeadBits = 2 + 38 + 3 * (1 + 48 + 32) + 3 * 6;

/// One number of `bits` bits, at most 48, from the top, 16 bits at a time.
template <class Io>
std::uint64_t plain_number(Io& io, std::uint64_t value, std::uint32_t bits) noexcept {
  std::uint64_t result = 0;
  while (bits > 0) {
    const std::uint32_t part = (bits - 1) % 16 + 1;
    bits -= part;
    const auto digits = static_cast<std::uint32_t>(value >> bits) & ((1U << part) - 1);
    result |= std::uint64_t{io.raw(digits, static_cast<int>(part))} << bits;
  }
  return result;
}

/// The head. Axes without a pitch of their own keep the pitch they came with. kFieldRange: a length
/// over 32 or a pitch out of range.
template <class Io>
Status point_head(Io& io, PointHead& head) noexcept {
  const std::uint32_t length = io.raw(static_cast<std::uint32_t>(std::bit_width(head.points)), 6);
  if (length > 32) return Status::kFieldRange;
  head.points = static_cast<std::uint32_t>(plain_number(io, head.points, length));
  for (std::size_t i = 0; i < 3; ++i) {
    head.own_pitch[i] = io.raw(head.own_pitch[i] ? 1 : 0, 1) != 0;
    CellAxis& axis = head.axes[i];
    if (head.own_pitch[i]) {
      axis.pitch = plain_number(io, axis.pitch, 48);
      if (axis.pitch < kLeastPitch || axis.pitch > kMostPitch) return Status::kFieldRange;
    }
    axis.base = static_cast<std::uint32_t>(plain_number(io, axis.base, 32));
  }
  return Status::kOk;
}

/// Widths of the numbers of a plain slice. kFieldRange: one over 32.
template <class Io>
Status plain_widths(Io& io, std::array<std::uint32_t, 3>& widths) noexcept {
  for (std::uint32_t& width : widths) {
    width = io.raw(width, 6);
    if (width > 32) return Status::kFieldRange;
  }
  return Status::kOk;
}

}  // namespace planecast
