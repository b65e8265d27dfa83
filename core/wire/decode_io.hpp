// How the codes that both halves share (raw tiles, patches, trees of points) read: the value handed
// in is ignored, that of the coder comes back. The encoder half's counterpart is encode_io.hpp.
#pragma once

#include <cstdint>

#include "core/wire/range_decoder.hpp"

namespace planecast {

struct DecodeIo {
  static constexpr bool kReads = true;
  RangeDecoder& coder;

  bool bit(BitModel& model, bool /*value*/) noexcept { return coder.bit(model); }
  int symbol(SymbolModel& model, int /*value*/) noexcept { return coder.symbol(model); }
  std::uint32_t raw(std::uint32_t /*value*/, int bits) noexcept { return coder.raw(bits); }
  /// The stream ended before what was read.
  bool failed() const noexcept { return coder.truncated(); }
};

}  // namespace planecast
