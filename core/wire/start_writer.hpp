// Writes what core/wire/start_io.hpp reads. Only training and tests do.
#pragma once

#include <cstdint>
#include <vector>

#include "core/wire/start_io.hpp"

namespace planecast {

class StartWriter {
 public:
  bool bit_at(std::uint32_t probability, bool value) {
    for (range_.take(value, range_.split(probability)); range_.settled(); range_.shift())
      bytes_.push_back(static_cast<std::uint8_t>(range_.high >> 24U));
    return value;
  }
  std::uint32_t raw(std::uint32_t value, int bits) {
    for (int bit = bits - 1; bit >= 0; --bit) bit_at(32768, (value >> bit & 1U) != 0);
    return value;
  }
  /// One byte between the bounds; zeros follow.
  std::vector<std::uint8_t> finish() {
    bytes_.push_back(static_cast<std::uint8_t>(range_.high >> 24U));
    return bytes_;
  }

 private:
  StartRange range_;
  std::vector<std::uint8_t> bytes_;
};

}  // namespace planecast
