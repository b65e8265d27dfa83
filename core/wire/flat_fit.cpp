#include "core/wire/flat_fit.hpp"

#include <algorithm>
#include <cstdlib>

#include "core/base/lanes.hpp"

namespace planecast {
namespace {

constexpr std::int32_t kAnything = std::int32_t{1} << 28;
constexpr std::int32_t kMostSteps = (std::int32_t{1} << (kPlaneLengths - 1)) - 1;

Int4 lesser4(Int4 a, Int4 b) noexcept {
  return a < b ? a : b;
}
Int4 greater4(Int4 a, Int4 b) noexcept {
  return a > b ? a : b;
}

std::int32_t floor_div(std::int32_t a, std::int32_t b) noexcept {
  return a >= 0 ? a / b : -((b - 1 - a) / b);
}

// Nearest whole number to a / b.
std::int32_t round_div(std::int64_t a, std::int64_t b) noexcept {
  return static_cast<std::int32_t>(a >= 0 ? (2 * a + b) / (2 * b) : -((2 * -a + b) / (2 * b)));
}

// Shifts of a plane with these slopes that every reading allows: least .. most, empty if greater.
struct Shifts {
  std::int32_t least, most;
};

Shifts allowed_shifts(const FlatWindow& window, const BlockSurface& at) noexcept {
  Int4 least = {-kAnything, -kAnything, -kAnything, -kAnything};
  Int4 most = -least;
  const Int4 right = {0, at.dx, 2 * at.dx, 3 * at.dx};
  for (std::int32_t y = 0; y < 8; ++y) {
    const std::int32_t begin = at.at_origin + y * at.dy;
    for (std::int32_t x = 0; x < 8; x += 4) {
      const std::int32_t first = begin + x * at.dx;
      const Int4 q = Int4{first, first, first, first} + right;
      least = greater4(least, load4(window.low + 8 * y + x) - q);
      most = lesser4(most, load4(window.high + 8 * y + x) - q);
    }
  }
  return {std::max(std::max(least[0], least[1]), std::max(least[2], least[3])),
          std::min(std::min(most[0], most[1]), std::min(most[2], most[3]))};
}

// Slopes of the least-squares plane through what is left of the readings beside `at`, 1/256 level.
struct Slopes {
  std::int32_t dx, dy;
};

Slopes residual_slopes(const FlatWindow& window, const BlockSurface& at) noexcept {
  std::int32_t left[64];
  std::int32_t sum = 0;
  for (std::int32_t y = 0; y < 8; ++y) {
    for (std::int32_t x = 0; x < 8; ++x) {
      const std::int32_t i = 8 * y + x;
      const std::int32_t there = -static_cast<std::int32_t>(window.own[i] != 0);
      left[i] = (window.own[i] - ((at.at_origin + x * at.dx + y * at.dy + 128) >> 8)) & there;
      sum += left[i];
    }
  }
  const std::int32_t mean = sum / std::max(window.readings, 1);
  std::int32_t along = 0, down = 0;
  for (std::int32_t y = 0; y < 8; ++y) {
    std::int32_t row = 0;
    for (std::int32_t x = 0; x < 8; ++x) {
      const std::int32_t there = -static_cast<std::int32_t>(window.own[8 * y + x] != 0);
      const std::int32_t off = (left[8 * y + x] - mean) & there;  // a hole pulls nowhere
      along += off * (2 * x - 7);
      row += off;
    }
    down += row * (2 * y - 7);
  }
  return {round_div(std::int64_t{along} * 256, 672), round_div(std::int64_t{down} * 256, 672)};
}

}  // namespace

void load_window(const CodingTables& tables, const std::uint16_t* depth, std::uint32_t width,
                 std::uint32_t columns, std::uint32_t rows, std::uint8_t ray_class,
                 FlatWindow& window) noexcept {
  const LevelTable levels = *tables.levels;
  const BoundTable& bounds = *tables.bounds;
  window.readings = 0;
  for (std::uint32_t y = 0; y < 8; ++y) {
    for (std::uint32_t x = 0; x < 8; ++x) {
      const std::uint32_t i = 8 * y + x;
      const std::uint16_t d = x < columns && y < rows ? depth[std::size_t{y} * width + x] : 0;
      window.low[i] = -kAnything;
      window.high[i] = kAnything;
      window.own[i] = 0;
      if (d == 0) continue;
      const std::uint32_t error = bounds.max_error(d, ray_class);
      const std::uint32_t least = d > error ? d - error : 1;
      const std::uint32_t most = std::min<std::uint32_t>(d + error, 65535);
      std::int32_t low = levels.nearest(static_cast<std::uint16_t>(least));
      std::int32_t high = levels.nearest(static_cast<std::uint16_t>(most));
      low += levels.depth(static_cast<std::uint32_t>(low)) < least;
      high -= levels.depth(static_cast<std::uint32_t>(high)) > most;
      window.low[i] = low * 256 - 128;
      window.high[i] = high * 256 + 127;
      window.own[i] = levels.nearest(d);
      ++window.readings;
    }
  }
}

bool fit_flat(const FlatWindow& window, const BlockPlane& foretold, const PlaneSteps& steps,
              std::int32_t last_level, FlatCode& code) noexcept {
  const auto attempt = [&](std::int32_t dx, std::int32_t dy, std::int32_t& gap) {
    if (std::abs(dx) > kMostSteps || std::abs(dy) > kMostSteps) return false;
    const BlockPlane tilted = BlockPlane::clamped(foretold.middle, foretold.dx + dx * steps.slope,
                                                  foretold.dy + dy * steps.slope, last_level);
    const Shifts shifts = allowed_shifts(window, tilted.surface());
    gap = shifts.least - shifts.most;
    const std::int32_t first = -floor_div(-shifts.least, steps.offset);
    const std::int32_t last = floor_div(shifts.most, steps.offset);
    if (first > last) return false;
    const std::int32_t offset = std::clamp(0, first, last);
    const std::int32_t moved = foretold.middle + offset * steps.offset;
    if (std::abs(offset) > kMostSteps || moved < 256 || moved > 256 * last_level) return false;
    code = {offset, dx, dy};
    return true;
  };
  std::int32_t gap = 0;
  if (attempt(0, 0, gap)) return true;
  const Slopes slopes = residual_slopes(window, foretold.surface());
  const std::int32_t dx = round_div(slopes.dx, steps.slope);
  const std::int32_t dy = round_div(slopes.dy, steps.slope);
  if (dx != 0 && dy != 0) {
    if (attempt(dx, 0, gap) || attempt(0, dy, gap)) return true;
  }
  if (attempt(dx, dy, gap)) return true;
  // Slopes a step off move a corner by 7 steps' worth at most: what is far from fitting never will.
  if (gap > 7 * steps.slope + steps.offset) return false;
  constexpr std::int32_t kAround[8][2] = {{1, 0}, {-1, 0},  {0, 1},  {0, -1},
                                          {1, 1}, {-1, -1}, {1, -1}, {-1, 1}};
  for (const auto& [ox, oy] : kAround) {
    if (attempt(dx + ox, dy + oy, gap)) return true;
  }
  return false;
}

}  // namespace planecast
