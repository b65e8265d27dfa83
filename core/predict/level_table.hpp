// Levels: the depth counts a sensor can say, in rising order, so that neighbours differ by small
// numbers. Stereo and structured light only say C / (k + offset); other sensors say every count.
// Both halves build the same table from the key packet, by integers only.
#pragma once

#include <cstdint>
#include <span>

#include "core/base/arena.hpp"
#include "core/base/lanes.hpp"
#include "core/base/status.hpp"
#include "core/model/stream_config.hpp"

namespace planecast {

/// Depth count of a lattice's step k >= 1: C / (k + offset), rounded or cut; may exceed 65535.
inline std::uint64_t lattice_depth(const Lattice& lattice, std::uint64_t k) noexcept {
  const std::uint64_t divisor_q16 = (k << 16U) + lattice.offset_q16;
  const std::uint64_t depth_q8 = (std::uint64_t{lattice.c_q8} << 16U) / divisor_q16;
  return (depth_q8 + (lattice.truncated ? 0U : 128U)) >> 8U;
}

/// Level <-> depth count. Level 0 means "no reading"; levels 1 .. count-1 are depths in rising
/// order. Read-only after build(); any thread. Memory: 256 KiB from the arena.
class LevelTable {
 public:
  /// Takes the table's memory; call while starting.
  void layout(Arena& arena) noexcept;

  /// Fills the table for a lattice (or the identity). O(65536); kFieldRange for a lattice whose
  /// spacing reaches the whole range (C below 2 counts).
  Status build(const Lattice& lattice) noexcept;

  /// Levels in use, including level 0: 2 .. 65536.
  std::uint32_t count() const noexcept { return count_; }

  /// The sensor has no lattice: every count is a level.
  bool every_count() const noexcept { return lattice_.c_q8 == 0; }

  /// Depth count of a level below count().
  std::uint16_t depth(std::uint32_t level) const noexcept { return depth_[level]; }

  /// Depth counts of `count` levels.
  void depths(const std::uint16_t* level, std::uint32_t count, std::uint16_t* out) const noexcept {
    const std::uint16_t* const table = depth_.data();
    if (count == 8) {
      const Count8 all = {table[level[0]], table[level[1]], table[level[2]], table[level[3]],
                          table[level[4]], table[level[5]], table[level[6]], table[level[7]]};
      store8(out, all);
      return;
    }
    for (std::uint32_t i = 0; i < count; ++i) out[i] = table[level[i]];
  }

  /// The level nearest to a depth count (0 for 0); exact when depth(level) gives the count back.
  std::uint16_t nearest(std::uint16_t depth_count) const noexcept { return nearest_[depth_count]; }

  /// Position of an inverse depth among the levels, in 1/256 level, clamped to the table. `iv` in
  /// steps of 2^-31 per count; values below 1 are taken as 1.
  std::int32_t level_q8(std::int64_t iv) const noexcept {
    if (iv < 1) iv = 1;
    if (iv > lattice_most_iv_) {
      return clamp_q8(static_cast<std::int64_t>(kOneQ8 / static_cast<std::uint64_t>(iv)));
    }
    const auto k_q8 = static_cast<std::int64_t>(
        (static_cast<std::uint64_t>(lattice_.c_q8) * static_cast<std::uint64_t>(iv)) >> 31U);
    return clamp_q8(top_q8_ - k_q8);
  }

 private:
  std::int32_t clamp_q8(std::int64_t level_q8) const noexcept {
    if (level_q8 < 256) return 256;
    const std::int64_t last = std::int64_t{count_ - 1} * 256;
    return static_cast<std::int32_t>(level_q8 < last ? level_q8 : last);
  }

  Lattice lattice_;
  std::uint32_t count_ = 0;
  static constexpr std::uint64_t kOneQ8 = std::uint64_t{1} << 39U;  ///< inverse of 1/256 count
  std::int64_t lattice_most_iv_ = 0;  ///< beyond this inverse depth every count is a level
  std::int64_t top_q8_ = 0;           ///< level_q8 of the lattice's k + offset = 0
  std::span<std::uint16_t> depth_;
  std::span<std::uint16_t> nearest_;
};

}  // namespace planecast
