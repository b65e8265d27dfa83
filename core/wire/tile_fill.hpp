// How a tile may end early: at the row of blocks that would no longer fit its slice. What was coded
// so far is a whole tile of less height, so a slice is full and nothing is coded twice.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/wire/range_encoder.hpp"
#include "core/wire/tile_write.hpp"

namespace planecast {

/// What is expected of a tile that may end early. Empty: all of its rectangle or nothing.
struct TileFill {
  std::span<const float> row_bits = {};  ///< bits expected of each of its rows of blocks
  std::uint32_t planned = 0;  ///< rows that likely fit, 1..; the head names their surfaces

  bool allowed() const noexcept { return !row_bits.empty(); }
};

/// Watches a tile's rows of blocks go into a slice of `room` bytes. Encoder half.
class FillGate {
 public:
  FillGate(const TileFill& fill, std::size_t room) noexcept : fill_(fill), room_(room) {}

  bool allowed() const noexcept { return fill_.allowed(); }
  std::uint32_t rows() const noexcept { return rows_; }

  /// Whether row `row`, 1.., likely fits behind what `coder` holds, at the rate of the rows so far.
  bool likely(const RangeEncoder& coder, std::uint32_t row) const noexcept {
    constexpr float kHeadBits = 120, kPrior = 512;
    const float used = static_cast<float>(coder.size()) * 8;
    const float next = fill_.row_bits[row] * (used + kPrior) / (expected_ + kHeadBits + kPrior);
    return used + next <= static_cast<float>(room_) * 8;
  }

  /// After a row was coded: keeps it when it fits with the end of the stream, else goes back to
  /// where the rows before it ended, and is false.
  bool keep(RangeEncoder& coder) noexcept {
    constexpr std::size_t kEndBytes = 8;
    if (coder.overflow() || coder.size() + kEndBytes > room_) {
      if (rows_ > 0) coder.go_back(mark_);
      return false;
    }
    mark_ = coder.mark();
    expected_ += fill_.row_bits[rows_++];
    return true;
  }

 private:
  const TileFill& fill_;
  std::size_t room_;
  RangeEncoder::Mark mark_{};
  float expected_ = 0;
  std::uint32_t rows_ = 0;
};

/// Makes a finished tile say that it is `rows` blocks high where its head said `said`; returns the
/// bytes it has then. The height is plain bits of the first eight bytes: a difference is added.
inline std::size_t recode_height(std::span<std::uint8_t> out, std::size_t used,
                                 const CameraModel& camera, std::uint32_t said,
                                 std::uint32_t rows) noexcept {
  const int bits = 1 + rect_bits(camera);
  const std::uint64_t unit = ~std::uint64_t{0} >> bits;
  std::uint64_t first = 0;
  const auto at = [&](std::size_t i) -> std::uint8_t& { return out[i]; };
  for (std::size_t i = 0; i < 8; ++i) first = first << 8U | (i < used ? at(i) : 0U);
  first += (std::uint64_t{rows} - said) * unit;  // modulo 2^64
  for (std::size_t i = 0; i < 8; ++i) at(i) = static_cast<std::uint8_t>(first >> (56U - 8U * i));
  return std::max<std::size_t>(used, 8);  // zeros at its end may stand for decisions: they stay
}

}  // namespace planecast
