// How the slice target reads its input, shared with the program that makes its first inputs:
//   u8 stream (index of the golden streams, modulo their number; high bit: packets as they are,
//   else their headers are made right), then packets or bodies, each after its length as u16.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/bytes.hpp"

namespace planecast::test {

inline constexpr std::uint8_t kAsItIs = 0x80;

/// Takes the next part off the front of `in`; a length past the end means the rest.
inline std::span<const std::uint8_t> take_part(std::span<const std::uint8_t>& in) noexcept {
  if (in.size() < 2) {
    in = {};
    return {};
  }
  const std::size_t length =
      std::min<std::size_t>(load_le<std::uint16_t>(in.data()), in.size() - 2);
  const auto part = in.subspan(2, length);
  in = in.subspan(2 + length);
  return part;
}

/// Appends a part, at most 65535 bytes.
inline void append_part(std::vector<std::uint8_t>& out, std::span<const std::uint8_t> part) {
  const std::size_t at = out.size();
  out.resize(at + 2);
  store_le<std::uint16_t>(&out[at], static_cast<std::uint16_t>(part.size()));
  out.insert(out.end(), part.begin(), part.end());
}

}  // namespace planecast::test
