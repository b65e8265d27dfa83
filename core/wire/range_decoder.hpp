// The decoder of range_encoder.hpp. Reads zeros past the end, and counts them: a stream that
// needs more than a few was cut.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/wire/bit_model.hpp"

namespace planecast {

/// Reads decisions from `in`, which must outlive it. Never reads outside; allocates nothing.
class RangeDecoder {
 public:
  explicit RangeDecoder(std::span<const std::uint8_t> in) noexcept : in_(in) {
    for (int i = 0; i < 4; ++i) code_ = (code_ << 8U) | next();
  }

  bool bit(BitModel& model) noexcept {
    const std::uint32_t split = (range_ >> 16U) * model.probability();
    const bool value = code_ < split;
    if (value) {
      range_ = split;
    } else {
      code_ -= split;
      range_ -= split;
    }
    model.update(value);
    normalise();
    return value;
  }

  std::uint32_t raw(int count) noexcept {
    range_ >>= count;
    std::uint32_t value = code_ / range_;
    const std::uint32_t most = (1U << count) - 1U;
    if (value > most) value = most;  // only in corrupt streams
    code_ -= value * range_;
    normalise();
    return value;
  }

  /// True when more bytes were needed than an encoder's finish() ever leaves out.
  bool truncated() const noexcept { return past_end_ > 5; }
  /// True when bytes are left that no decision used.
  bool trailing() const noexcept { return used_ < in_.size(); }

 private:
  std::uint32_t next() noexcept {
    if (used_ < in_.size()) return in_[used_++];
    ++past_end_;
    return 0;
  }

  void normalise() noexcept {
    while (range_ < (1U << 24U)) {
      range_ <<= 8U;
      code_ = (code_ << 8U) | next();
    }
  }

  std::span<const std::uint8_t> in_;
  std::size_t used_ = 0;
  std::size_t past_end_ = 0;
  std::uint32_t range_ = 0xffffffffU;
  std::uint32_t code_ = 0;
};

}  // namespace planecast
