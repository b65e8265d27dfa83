// The correction of a depth reading that its prediction does not hold. Encoder half, seen by the
// two tile packers only.
#pragma once

#include <cstdint>
#include <cstdlib>

#include "core/predict/bound_table.hpp"
#include "core/predict/level_table.hpp"
#include "core/wire/tile_models.hpp"

namespace planecast {

struct Correction {
  std::int32_t steps = 0;  ///< signed; of kMaxUnary + 1 a jump follows
  std::int32_t level = 0;  ///< where it leads, the reading's own level after a jump
  std::int32_t jump = 0;   ///< levels from the prediction; 0: the count itself
};

/// The least correction from `prediction` (a level, its half width, its step) to a level within the
/// window of `depth`. A few table look-ups.
template <class Prediction>
Correction find_correction(const LevelTable& levels, const Prediction& prediction,
                           std::uint16_t depth, LevelWindow window,
                           std::int32_t last_level) noexcept {
  const auto within = [&](std::int32_t level) {
    return level >= window.low && level <= window.high;
  };
  const std::int32_t start = prediction.level;
  const std::int32_t own = levels.nearest(depth);
  const bool up =
      own > start || (own == start && depth > levels.depth(static_cast<std::uint32_t>(own)));
  const int sign = up ? 1 : -1;
  const std::int32_t step = prediction.step();
  const std::int32_t far = std::abs(own - start);
  // The first step whose window may hold the reading, and the three after it.
  const std::int32_t least = far - 2 * prediction.half_width;
  const std::int32_t first = least < 2 * step ? 1 : least / step;
  for (std::int32_t n = first; n <= first + 3 && n <= kMaxUnary; ++n) {
    const std::int32_t level = start + sign * n * step;
    if (level < 1 || level > last_level) break;
    if (within(level)) return {sign * n, level, 0};
  }
  return {sign * (kMaxUnary + 1), own, within(own) ? far : 0};
}

}  // namespace planecast
