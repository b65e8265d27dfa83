// The decoder of range_encoder.hpp. Reads zeros past the end, and counts them: a stream that
// needs more than an encoder ever leaves out was cut.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/wire/bit_model.hpp"
#include "core/wire/symbol_model.hpp"

namespace planecast {

/// Reads decisions from `in`, which must outlive it. Never reads outside; allocates nothing.
class RangeDecoder {
 public:
  explicit RangeDecoder(std::span<const std::uint8_t> in) noexcept : in_(in) {
    code_ = next_word();
    code_ = (code_ << 32U) | next_word();
  }

  bool bit(BitModel& model) noexcept {
    // Each outcome on a path of its own: the branch is taken anyway.
    if (bit_at(model.probability())) {
      model.update(true);
      return true;
    }
    model.update(false);
    return false;
  }

  /// A decision whose probability of a 1 is `probability` / 65536, 1 .. 65535.
  bool bit_at(std::uint32_t probability) noexcept {
    const std::uint64_t split = (range_ >> 16U) * probability;
    const bool value = code_ < split;
    if (value) {
      range_ = split;
    } else {
      code_ -= split;
      range_ -= split;
    }
    normalise();
    return value;
  }

  /// One of sixteen symbols, by a SymbolModel or a SymbolPair.
  template <class Model>
  int symbol(Model&& model) noexcept {
    const std::uint64_t part = range_ >> detail::kSymbolTotalBits;
    const std::uint64_t value = std::min<std::uint64_t>(code_ / part, 32767);
    const int found = model.find(static_cast<std::int32_t>(value));
    const std::uint32_t low = model.low(found), high = model.high(found);
    code_ -= low * part;
    range_ = (high - low) * part;
    model.update(found);
    normalise();
    return found;
  }

  /// `count` bits (1..16), each equally likely.
  std::uint32_t raw(int count) noexcept {
    range_ >>= count;
    const std::uint64_t most = (std::uint64_t{1} << count) - 1;
    const std::uint64_t value = std::min(code_ / range_, most);  // more: only in corrupt streams
    code_ -= value * range_;
    normalise();
    return static_cast<std::uint32_t>(value);
  }

  /// True when more bytes were needed than an encoder's finish() ever leaves out.
  bool truncated() const noexcept { return past_end_ > 8; }
  /// True when bytes are left that no decision used.
  bool trailing() const noexcept { return used_ < in_.size(); }

 private:
  static constexpr std::uint64_t kLeastRange = std::uint64_t{1} << 32U;

  std::uint64_t next_word() noexcept {
    std::uint32_t word = 0;
    if (in_.size() - used_ >= 4) {
      for (unsigned i = 0; i < 4; ++i) word = (word << 8U) | in_[used_ + i];
      used_ += 4;
      return word;
    }
    for (unsigned i = 0; i < 4; ++i) {
      const bool left = used_ < in_.size();
      word = (word << 8U) | (left ? in_[used_] : 0U);
      used_ += left ? 1 : 0;
      past_end_ += left ? 0 : 1;
    }
    return word;
  }

  void normalise() noexcept {
    if (range_ >= kLeastRange) return;
    range_ <<= 32U;
    code_ = (code_ << 32U) | next_word();
  }

  std::span<const std::uint8_t> in_;
  std::size_t used_ = 0;
  std::size_t past_end_ = 0;
  std::uint64_t range_ = ~std::uint64_t{0};
  std::uint64_t code_ = 0;
};

}  // namespace planecast
