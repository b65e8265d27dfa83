// Z-order (Morton) keys of cells with 32 bits a coordinate, and sorting by them. Encoder half.
#pragma once

#include <array>
#include <cstdint>
#include <span>

namespace planecast {

/// A cell's 96 interleaved bits, x lowest, and a point that lies in it or their number.
struct ZKey {
  std::uint64_t low = 0;
  std::uint32_t high = 0;
  std::uint32_t point = 0;

  bool same_cell(const ZKey& other) const noexcept {
    return low == other.low && high == other.high;
  }
  /// The octant (x + 2 y + 4 z) at `level`; level 0 tells neighbouring cells apart.
  std::uint32_t octant(unsigned level) const noexcept {
    const unsigned shift = 3 * level;
    if (shift < 63) return static_cast<std::uint32_t>(low >> shift) & 7U;
    if (shift == 63) return static_cast<std::uint32_t>(low >> 63U) | ((high & 3U) << 1U);
    return (high >> (shift - 64)) & 7U;
  }
};

/// The key of cell (x, y, z).
ZKey z_key(std::uint32_t x, std::uint32_t y, std::uint32_t z, std::uint32_t point) noexcept;

/// The cell of a key.
std::array<std::uint32_t, 3> z_cell(const ZKey& key) noexcept;

/// Levels on which two cells differ: their lower bits, 0 (the same) .. 32.
unsigned z_depth(const ZKey& a, const ZKey& b) noexcept;

/// Sorts `keys` by cell, equal cells in the order they came. `spare` has the same size. O(n).
void sort_z_keys(std::span<ZKey> keys, std::span<ZKey> spare) noexcept;

}  // namespace planecast
