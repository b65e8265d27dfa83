// Reads the packed starts of models (start_code.hpp): a binary arithmetic coder of 32 bits, small
// in code (after Mahoney's lpaq). Of neither half: both start from the same constants.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace planecast {

/// What lies between two 32-bit bounds.
struct StartRange {
  std::uint32_t low = 0, high = ~std::uint32_t{0};

  /// Where a 1 of this probability in 1/65536 ends.
  std::uint32_t split(std::uint32_t probability) const noexcept {
    return low + static_cast<std::uint32_t>(std::uint64_t{high - low} * probability >> 16U);
  }
  void take(bool value, std::uint32_t split) noexcept { (value ? high : low) = split + !value; }
  /// The bounds begin with the same byte.
  bool settled() const noexcept { return ((low ^ high) >> 24U) == 0; }
  void shift() noexcept {
    low <<= 8U;
    high = high << 8U | 255U;
  }
};

/// Reads constants of the program: they are not checked. Past their end it reads zeros.
class StartReader {
 public:
  explicit StartReader(std::span<const std::uint8_t> in) noexcept : in_(in) {
    for (int i = 0; i < 4; ++i) code_ = code_ << 8U | next_byte();
  }

  bool bit_at(std::uint32_t probability, bool /*value*/) noexcept {
    const std::uint32_t split = range_.split(probability);
    const bool value = code_ <= split;
    for (range_.take(value, split); range_.settled(); range_.shift())
      code_ = code_ << 8U | next_byte();
    return value;
  }
  std::uint32_t raw(std::uint32_t /*value*/, int bits) noexcept {
    std::uint32_t value = 0;
    for (; bits > 0; --bits) value = 2 * value + std::uint32_t{bit_at(32768, false)};
    return value;
  }

 private:
  std::uint32_t next_byte() noexcept { return at_ < in_.size() ? in_[at_++] : 0U; }

  std::span<const std::uint8_t> in_;
  std::size_t at_ = 0;
  StartRange range_;
  std::uint32_t code_ = 0;
};

}  // namespace planecast
