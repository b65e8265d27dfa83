// Little-endian loads and stores, independent of the machine's own order and alignment.
#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>

namespace planecast {

/// Reads an unsigned integer of sizeof(T) bytes, least significant byte first.
template <class T>
inline T load_le(const std::uint8_t* bytes) noexcept {
  static_assert(std::is_unsigned_v<T>);
  T value = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i)
    value = static_cast<T>(value | (static_cast<T>(bytes[i]) << (8U * i)));
  return value;
}

/// Writes an unsigned integer of sizeof(T) bytes, least significant byte first.
template <class T>
inline void store_le(std::uint8_t* bytes, T value) noexcept {
  static_assert(std::is_unsigned_v<T>);
  for (std::size_t i = 0; i < sizeof(T); ++i)
    bytes[i] = static_cast<std::uint8_t>(value >> (8U * i));
}

/// Reads an unsigned integer, most significant byte first (LCM's order).
template <class T>
inline T load_be(const std::uint8_t* bytes) noexcept {
  static_assert(std::is_unsigned_v<T>);
  T value = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i) value = static_cast<T>((value << 8U) | bytes[i]);
  return value;
}

/// Writes an unsigned integer, most significant byte first (LCM's order).
template <class T>
inline void store_be(std::uint8_t* bytes, T value) noexcept {
  static_assert(std::is_unsigned_v<T>);
  for (std::size_t i = 0; i < sizeof(T); ++i)
    bytes[i] = static_cast<std::uint8_t>(value >> (8U * (sizeof(T) - 1U - i)));
}

}  // namespace planecast
