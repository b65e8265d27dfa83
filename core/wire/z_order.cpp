#include "core/wire/z_order.hpp"

#include <algorithm>
#include <array>
#include <bit>

namespace planecast {
namespace {

// The lower 21 bits of `value`, each followed by two zeros.
std::uint64_t spread(std::uint64_t value) noexcept {
  value &= 0x1fffffU;
  value = (value | value << 32U) & 0x1f00000000ffffU;
  value = (value | value << 16U) & 0x1f0000ff0000ffU;
  value = (value | value << 8U) & 0x100f00f00f00f00fU;
  value = (value | value << 4U) & 0x10c30c30c30c30c3U;
  return (value | value << 2U) & 0x1249249249249249U;
}

// Every third bit of `value`, the inverse of spread.
std::uint32_t gather(std::uint64_t value) noexcept {
  value &= 0x1249249249249249U;
  value = (value | value >> 2U) & 0x10c30c30c30c30c3U;
  value = (value | value >> 4U) & 0x100f00f00f00f00fU;
  value = (value | value >> 8U) & 0x1f0000ff0000ffU;
  value = (value | value >> 16U) & 0x1f00000000ffffU;
  return static_cast<std::uint32_t>(value | value >> 32U) & 0x1fffffU;
}

constexpr unsigned kDigitBits = 11;
constexpr unsigned kDigits = 9;  // 96 bits

std::uint32_t digit(const ZKey& key, unsigned i) noexcept {
  constexpr std::uint32_t kMask = (1U << kDigitBits) - 1;
  const unsigned shift = i * kDigitBits;
  if (shift + kDigitBits <= 64) return static_cast<std::uint32_t>(key.low >> shift) & kMask;
  if (shift >= 64) return (key.high >> (shift - 64)) & kMask;
  return (static_cast<std::uint32_t>(key.low >> shift) | (key.high << (64 - shift))) & kMask;
}

}  // namespace

ZKey z_key(std::uint32_t x, std::uint32_t y, std::uint32_t z, std::uint32_t point) noexcept {
  const std::uint64_t low = spread(x) | spread(y) << 1U | spread(z) << 2U;
  const std::uint64_t high =
      spread(x >> 21U) | spread(y >> 21U) << 1U | spread(z >> 21U) << 2U;  // 33 bits
  return {low | high << 63U, static_cast<std::uint32_t>(high >> 1U), point};
}

std::array<std::uint32_t, 3> z_cell(const ZKey& key) noexcept {
  const std::uint64_t high = std::uint64_t{key.high} << 1U | key.low >> 63U;
  std::array<std::uint32_t, 3> cell{};
  for (unsigned axis = 0; axis < 3; ++axis)
    cell[axis] = gather(key.low >> axis) | gather(high >> axis) << 21U;
  return cell;
}

unsigned z_depth(const ZKey& a, const ZKey& b) noexcept {
  const std::uint32_t high = a.high ^ b.high;
  const std::uint64_t low = a.low ^ b.low;
  const auto bits =
      static_cast<unsigned>(high != 0 ? 64 + std::bit_width(high) : std::bit_width(low));
  return (bits + 2) / 3;
}

void sort_z_keys(std::span<ZKey> keys, std::span<ZKey> spare) noexcept {
  std::uint64_t low = 0;
  std::uint32_t high = 0;
  for (const ZKey& key : keys) {
    low |= key.low ^ keys[0].low;
    high |= key.high ^ keys[0].high;
  }
  const ZKey differing{low, high, 0};
  ZKey* from = keys.data();
  ZKey* to = spare.data();
  for (unsigned i = 0; i < kDigits; ++i) {
    if (digit(differing, i) == 0) continue;
    std::array<std::uint32_t, 1U << kDigitBits> starts{};
    for (std::size_t k = 0; k < keys.size(); ++k) ++starts[digit(from[k], i)];
    std::uint32_t sum = 0;
    for (std::uint32_t& start : starts) {
      const std::uint32_t count = start;
      start = sum;
      sum += count;
    }
    for (std::size_t k = 0; k < keys.size(); ++k) to[starts[digit(from[k], i)]++] = from[k];
    std::swap(from, to);
  }
  if (from != keys.data()) std::copy_n(from, keys.size(), keys.data());
}

}  // namespace planecast
