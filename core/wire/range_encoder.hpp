// Binary range encoder (32-bit range, carry by a counter of pending 0xff bytes, after Martin 1979
// as used in LZMA) into memory of fixed size.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/wire/bit_model.hpp"

namespace planecast {

/// Writes decisions into `out`; a full buffer sets overflow() and nothing is written past it.
/// Not thread-safe; allocates nothing.
class RangeEncoder {
 public:
  explicit RangeEncoder(std::span<std::uint8_t> out) noexcept : out_(out) {}

  void bit(BitModel& model, bool value) noexcept {
    const std::uint32_t split = (range_ >> 16U) * model.probability();
    if (value) {
      range_ = split;
    } else {
      low_ += split;
      range_ -= split;
    }
    model.update(value);
    normalise();
  }

  /// `count` bits (1..16) of `value`, each costing one bit.
  void raw(std::uint32_t value, int count) noexcept {
    range_ >>= count;
    low_ += std::uint64_t{value} * range_;
    normalise();
  }

  /// Ends the stream with as few bytes as tell it apart; returns the bytes written.
  std::size_t finish() noexcept {
    // The value in [low, low + range) with the most trailing zero bits; zeros need not be sent,
    // the decoder reads zeros past the end.
    for (int zeros = 31; zeros >= 0; --zeros) {
      const std::uint64_t mask = (std::uint64_t{1} << zeros) - 1;
      const std::uint64_t value = (low_ + mask) & ~mask;
      if (value < low_ + range_) {
        low_ = value;
        break;
      }
    }
    const std::size_t needed = size();
    for (int i = 0; i < 5; ++i) shift();
    while (used_ > needed && !overflow_ && out_[used_ - 1] == 0) --used_;
    return used_;
  }

  bool overflow() const noexcept { return overflow_; }
  /// Bytes written so far; a few more are pending.
  std::size_t size() const noexcept { return used_ + pending_; }

 private:
  void normalise() noexcept {
    while (range_ < (1U << 24U)) {
      range_ <<= 8U;
      shift();
    }
  }

  void shift() noexcept {
    if (static_cast<std::uint32_t>(low_) < 0xff000000U || (low_ >> 32U) != 0) {
      const auto carry = static_cast<std::uint8_t>(low_ >> 32U);
      if (started_) put(static_cast<std::uint8_t>(cache_ + carry));
      for (; pending_ > 0; --pending_) put(static_cast<std::uint8_t>(0xffU + carry));
      started_ = true;
      cache_ = static_cast<std::uint8_t>(low_ >> 24U);
    } else {
      ++pending_;
    }
    low_ = (low_ & 0x00ffffffU) << 8U;
  }

  void put(std::uint8_t byte) noexcept {
    if (used_ < out_.size()) {
      out_[used_++] = byte;
    } else {
      overflow_ = true;
    }
  }

  std::span<std::uint8_t> out_;
  std::size_t used_ = 0;
  std::size_t pending_ = 0;
  std::uint64_t low_ = 0;
  std::uint32_t range_ = 0xffffffffU;
  std::uint8_t cache_ = 0;
  bool started_ = false;
  bool overflow_ = false;
};

}  // namespace planecast
