// How the codes that both halves share (raw tiles, patches, trees of points) write: the value goes
// into the coder and comes back as it was. The decoder half's counterpart is decode_io.hpp.
#pragma once

#include <cstdint>

#include "core/wire/range_encoder.hpp"

namespace planecast {

struct EncodeIo {
  static constexpr bool kReads = false;
  RangeEncoder& coder;

  bool bit(BitModel& model, bool value) noexcept {
    coder.bit(model, value);
    return value;
  }
  int symbol(SymbolModel& model, int value) noexcept {
    coder.symbol(model, value);
    return value;
  }
  std::uint32_t raw(std::uint32_t value, int bits) noexcept {
    coder.raw(value, bits);
    return value;
  }
  /// The coder's room is used up: nothing written since counts.
  bool failed() const noexcept { return coder.overflow(); }
};

}  // namespace planecast
