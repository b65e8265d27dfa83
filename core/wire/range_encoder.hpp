// Binary range encoder into memory of fixed size: 64-bit range, 32 bits out at a time, a carry goes
// back into the bytes already written (after Martin 1979).
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/wire/bit_model.hpp"
#include "core/wire/symbol_model.hpp"

namespace planecast {

/// Writes decisions into `out`; a full buffer sets overflow() and nothing is written past it.
/// Not thread-safe; allocates nothing.
class RangeEncoder {
 public:
  explicit RangeEncoder(std::span<std::uint8_t> out) noexcept : out_(out) {}

  void bit(BitModel& model, bool value) noexcept {
    // A copy: what is written to `out` may be the model, as far as a compiler knows.
    BitModel learned = model;
    learned.update(value);
    bit_at(model.probability(), value);
    model = learned;
  }

  /// A decision whose probability of a 1 is `probability` / 65536, 1 .. 65535.
  void bit_at(std::uint32_t probability, bool value) noexcept {
    const std::uint64_t split = (range_ >> 16U) * probability;
    // Without a branch on what no processor could foresee: the lower part is a 1's.
    const std::uint64_t upper = std::uint64_t{value} - 1;  // all bits of a 0
    add(split & upper);
    range_ = ((range_ & upper) - upper) + (split ^ upper);
    if (range_ < kLeastRange) [[unlikely]]
      shift();
  }

  /// One of sixteen symbols, by a SymbolModel or a SymbolPair.
  template <class Model>
  void symbol(Model&& model, int value) noexcept {
    const std::uint32_t low = model.low(value), high = model.high(value);
    range_ >>= detail::kSymbolTotalBits;
    add(low * range_);
    range_ *= high - low;
    model.update(value);
    if (range_ < kLeastRange) shift();
  }

  /// `count` bits (1..16) of `value`, each costing one bit.
  void raw(std::uint32_t value, int count) noexcept {
    range_ >>= count;
    add(value * range_);
    if (range_ < kLeastRange) shift();
  }

  /// Ends the stream with as few bytes as tell it apart; returns the bytes written.
  std::size_t finish() noexcept {
    // The value in [low, low + range) with the most trailing zero bits; zeros need not be sent,
    // the decoder reads zeros past the end. Range is at least 2^32: some value is always found.
    for (int zeros = 63; zeros >= 0; --zeros) {
      const std::uint64_t mask = (std::uint64_t{1} << zeros) - 1;
      const std::uint64_t up = (low_ + mask) & ~mask;  // may pass 2^64: a carry
      if (up - low_ >= range_) continue;
      add(up - low_);
      break;
    }
    for (; low_ != 0; low_ <<= 8U) {
      if (used_ == out_.size()) {
        overflow_ = true;
        break;
      }
      out_[used_++] = static_cast<std::uint8_t>(low_ >> 56U);
    }
    return used_;
  }

  /// A place in the stream to go back to.
  struct Mark {
    std::size_t used = 0;
    std::uint64_t low = 0, range = 0;
    std::uint8_t last = 0;  ///< byte before it
  };
  Mark mark() const noexcept {
    return {used_, low_, range_, used_ > 0 ? out_[used_ - 1] : std::uint8_t{0}};
  }
  /// Forgets what was written since `mark`; there was no overflow then.
  void go_back(const Mark& mark) noexcept {
    used_ = mark.used;
    low_ = mark.low;
    range_ = mark.range;
    overflow_ = false;
    if (used_ == 0 || out_[used_ - 1] == mark.last) return;
    // One carry, never two, went back past the mark: it is taken off again.
    for (std::size_t i = used_; i > 0 && out_[i - 1]-- == 0; --i) {
    }
  }

  bool overflow() const noexcept { return overflow_; }
  /// Bytes written so far; up to eight more are pending.
  std::size_t size() const noexcept { return used_; }

 private:
  static constexpr std::uint64_t kLeastRange = std::uint64_t{1} << 32U;

  void add(std::uint64_t value) noexcept {
    low_ += value;
    // Past an overflow words are lost, and what they carry must not reach those before them.
    if (low_ < value) [[unlikely]]
      carry(out_.data(), overflow_ ? 0 : used_);
  }

  // Given what it needs, not the coder: a coder whose address is nowhere stays in registers.
  [[gnu::noinline]] static void carry(std::uint8_t* out, std::size_t used) noexcept {
    for (std::size_t i = used; i > 0 && ++out[i - 1] == 0; --i) {
    }
  }

  void shift() noexcept {
    const auto word = static_cast<std::uint32_t>(low_ >> 32U);
    low_ <<= 32U;
    range_ <<= 32U;
    if (out_.size() - used_ < 4) {
      overflow_ = true;
      return;
    }
    std::uint8_t* const to = out_.data() + used_;
    for (unsigned i = 0; i < 4; ++i) to[i] = static_cast<std::uint8_t>(word >> (24U - 8U * i));
    used_ += 4;
  }

  std::span<std::uint8_t> out_;
  std::size_t used_ = 0;
  std::uint64_t low_ = 0;
  std::uint64_t range_ = ~std::uint64_t{0};
  bool overflow_ = false;
};

}  // namespace planecast
