#include "core/wire/flat_fit.hpp"

#include <algorithm>
#include <bit>
#include <cstdlib>

#include "core/base/lanes.hpp"

namespace planecast {
namespace {

constexpr std::int32_t kAnything = std::int32_t{1} << 28;
constexpr std::int32_t kMostSteps = (std::int32_t{1} << (kPlaneLengths - 1)) - 1;
// Levels around `base` within which sums of four fit 16 bits, eight times as much for a hole's.
constexpr std::int32_t kComparable = 1000;
// Levels around `base` of a narrow window, and how far a plane may be from it, in 1/256 level:
// their differences fit 16 bits.
constexpr std::int32_t kNarrow = 62, kNear = 16383;

// Nearest whole number to a / b.
std::int32_t round_div(std::int64_t a, std::int64_t b) noexcept {
  return static_cast<std::int32_t>(a >= 0 ? (2 * a + b) / (2 * b) : -((2 * -a + b) / (2 * b)));
}

// Shifts of a plane with these slopes that every reading allows: least .. most, empty if greater.
struct Shifts {
  std::int32_t least, most;
};

// Of the whole steps within the shifts the nearest to none; outside them where there is none.
std::int32_t nearest_step(const Shifts& shifts, std::int32_t step) noexcept {
  if (shifts.least > 0) return (shifts.least + step - 1) / step;
  return shifts.most < 0 ? -((step - 1 - shifts.most) / step) : 0;
}

// The same, within their middle two fifths where these have one. A shift of nothing that is only
// just allowed costs no bits, but puts all the readings to one side: taking the middle costs one
// bit in a hundred and brings points a fifth closer.
std::int32_t best_step(const Shifts& shifts, std::int32_t step) noexcept {
  const std::int32_t spare = (shifts.most - shifts.least) * 3 / 10;
  const Shifts middle{shifts.least + spare, shifts.most - spare};
  const std::int32_t steps = nearest_step(middle, step);
  const bool within = steps * step >= middle.least && steps * step <= middle.most;
  return within ? steps : nearest_step(shifts, step);
}

// A surface within kNear of a narrow window's base at all its pixels, as 16 bits.
struct NearSurface {
  std::int16_t at_origin = 0, dy = 0;
  Short8 right = {};  // what the columns add
  bool near = false;

  NearSurface(const FlatWindow& window, const BlockSurface& s) noexcept {
    const std::int32_t first = s.at_origin - window.base * 256;
    const std::int32_t x = 7 * s.dx, y = 7 * s.dy;
    const std::int32_t least = first + std::min(x, 0) + std::min(y, 0);
    const std::int32_t most = first + std::max(x, 0) + std::max(y, 0);
    near = window.narrow && least >= -kNear && most <= kNear;
    if (!near) return;
    at_origin = static_cast<std::int16_t>(first);
    dy = static_cast<std::int16_t>(s.dy);
    right = all8(static_cast<std::int16_t>(s.dx)) * Short8{0, 1, 2, 3, 4, 5, 6, 7};
  }
  Short8 row(int y) const noexcept {
    return all8(static_cast<std::int16_t>(at_origin + y * dy)) + right;
  }
};

// `holes` left out where there are none.
template <bool kHoles>
Shifts near_shifts(const FlatWindow& window, const NearSurface& at) noexcept {
  const Short8 lowest = all8(-32768), highest = all8(32767);
  Short8 least = lowest, most = highest;
  for (int y = 0; y < 8; ++y) {
    const Short8 q = at.row(y);
    Short8 low = minus8(load8(window.low_q8 + 8 * y), q);
    Short8 high = minus8(load8(window.high_q8 + 8 * y), q);
    if (kHoles) {
      const auto there = reinterpret_cast<Short8>(load8(window.high + 8 * y) != Count8{});
      low = there ? low : lowest;
      high = there ? high : highest;
    }
    least = max8(least, low);
    most = min8(most, high);
  }
  return {most8(least), least8(most)};
}

// Any surface, four readings at a time. Ends early where least is above most by more than
// `hopeless`.
Shifts far_shifts(const FlatWindow& window, const BlockSurface& at,
                  std::int32_t hopeless) noexcept {
  const Int4 lowest = Int4{} - kAnything, highest = Int4{} + kAnything;
  const Int4 across = at.dx * Int4{0, 1, 2, 3};
  Int4 least = lowest, most = highest;
  Shifts out{-kAnything, kAnything};
  for (int y = 0; y < 8 && out.least - out.most <= hopeless; ++y) {
    for (int x = 0; x < 8; x += 4) {
      const Int4 low = wide4(window.low + 8 * y + x), high = wide4(window.high + 8 * y + x);
      const Int4 q = across + (at.at_origin + x * at.dx + y * at.dy), hole = high == 0;
      const Int4 up = hole ? lowest : low * 256 - 128 - q;
      const Int4 down = hole ? highest : high * 256 + 127 - q;
      least = up > least ? up : least;
      most = down < most ? down : most;
    }
    out = {std::max(std::max(least[0], least[1]), std::max(least[2], least[3])),
           std::min(std::min(most[0], most[1]), std::min(most[2], most[3]))};
  }
  return out;
}

Shifts allowed_shifts(const FlatWindow& window, const BlockSurface& surface,
                      std::int32_t hopeless) noexcept {
  const NearSurface at(window, surface);
  if (!at.near) return far_shifts(window, surface, hopeless);
  return window.readings == 64 ? near_shifts<false>(window, at) : near_shifts<true>(window, at);
}

// True when three readings on a line, three pixels apart, allow no plane at all: over an edge, for
// one. Costs as much as trying one plane. Only windows of some range are told.
bool bent(const FlatWindow& window) noexcept {
  if (!window.comparable) return false;
  // Levels from base; a hole allows whatever the other two do.
  Short8 low[8], high[8];
  const Short8 base = all8(static_cast<std::int16_t>(window.base));
  for (int y = 0; y < 8; ++y) {
    const auto h = reinterpret_cast<Short8>(load8(window.high + 8 * y));
    const auto l = reinterpret_cast<Short8>(load8(window.low + 8 * y));
    const Short8 hole = h == Short8{};
    low[y] = (minus8(l, base) & ~hole) | (hole & all8(-8 * kComparable));
    high[y] = (minus8(h, base) & ~hole) | (hole & all8(8 * kComparable));
  }
  const Short8 none = {};
  Short8 most = {};
  const auto line = [&](Short8 l0, Short8 h0, Short8 l3, Short8 h3, Short8 l6, Short8 h6) {
    most = max8(most, max8(l0 + l6 - h3 - h3, l3 + l3 - h0 - h6));
  };
  for (int y = 0; y < 8; ++y) {
    const Short8 l = low[y], h = high[y];
    line(l, h, __builtin_shufflevector(l, none, 3, 4, 5, 6, 7, 8, 8, 8),
         __builtin_shufflevector(h, none, 3, 4, 5, 6, 7, 8, 8, 8),
         __builtin_shufflevector(l, none, 6, 7, 8, 8, 8, 8, 8, 8),
         __builtin_shufflevector(h, none, 6, 7, 8, 8, 8, 8, 8, 8));
  }
  most &= Short8{-1, -1};  // two lines a row
  for (int y = 0; y < 2; ++y)
    line(low[y], high[y], low[y + 3], high[y + 3], low[y + 6], high[y + 6]);
  // Levels stand for what rounds to them: half a level to either side of all three.
  return most8(most) >= 2;
}

// Slopes of the least-squares plane through what the windows' middles are off a surface, 1/256
// level.
struct Slopes {
  std::int32_t dx, dy;
};

// From sums over the pixels of how far the middle of each window is off, in halves of a level,
// times twice its distance from the block's middle.
Slopes slopes_of(std::int32_t along, std::int32_t down) noexcept {
  return {round_div(std::int64_t{along} * 128, 672), round_div(std::int64_t{down} * 128, 672)};
}

Slopes near_slopes(const FlatWindow& window, const NearSurface& at) noexcept {
  const Short8 quarter = all8(64), base = all8(static_cast<std::int16_t>(2 * window.base));
  Short8 left[8], there[8], sums = {};
  for (int y = 0; y < 8; ++y) {
    const Count8 high = load8(window.high + 8 * y);
    const auto both = reinterpret_cast<Short8>(load8(window.low + 8 * y) + high);
    there[y] = reinterpret_cast<Short8>(high != Count8{});
    left[y] = minus8(minus8(both, base), (at.row(y) + quarter) >> 7) & there[y];
    sums += left[y];
  }
  const std::int32_t mean = sum8(sums) / std::max(window.readings, 1);
  const Short8 weights = {-7, -5, -3, -1, 1, 3, 5, 7};
  Short8 along = {}, down = {};
  for (int y = 0; y < 8; ++y) {
    const Short8 off = (left[y] - all8(static_cast<std::int16_t>(mean))) & there[y];
    along += off * weights;
    down += off * all8(static_cast<std::int16_t>(2 * y - 7));
  }
  return slopes_of(sum8(along), sum8(down));
}

Slopes far_slopes(const FlatWindow& window, const BlockSurface& at) noexcept {
  std::int32_t left[64] = {};
  std::int32_t sum = 0;
  for (std::int32_t i = 0; i < 64; ++i) {
    if (window.high[i] == 0) continue;
    const std::int32_t q = at.at_origin + i % 8 * at.dx + i / 8 * at.dy;
    left[i] = window.low[i] + window.high[i] - ((q + 64) >> 7);
    sum += left[i];
  }
  const std::int32_t mean = sum / std::max(window.readings, 1);
  std::int32_t along = 0, down = 0;
  for (std::int32_t i = 0; i < 64; ++i) {
    if (window.high[i] == 0) continue;  // a hole pulls nowhere
    along += (left[i] - mean) * (2 * (i % 8) - 7);
    down += (left[i] - mean) * (2 * (i / 8) - 7);
  }
  return slopes_of(along, down);
}

Slopes residual_slopes(const FlatWindow& window, const BlockSurface& surface) noexcept {
  const NearSurface at(window, surface);
  return at.near ? near_slopes(window, at) : far_slopes(window, surface);
}

// Eight windows of depth counts: all lows, all highs.
struct EightWindows {
  Short8 low, high;
};

EightWindows load_windows(const LevelWindow* windows, const std::uint16_t* depth) noexcept {
  const auto pair = [&](int i) {
    std::int32_t both;
    std::memcpy(&both, windows + depth[i], sizeof both);
    return both;
  };
  const Int4 a = {pair(0), pair(1), pair(2), pair(3)}, b = {pair(4), pair(5), pair(6), pair(7)};
  const Short8 first = low_halves8(a, b), second = low_halves8(a >> 16, b >> 16);
  // LevelWindow lies in memory as it is declared, whichever half that is of a number.
  return std::endian::native == std::endian::little ? EightWindows{first, second}
                                                    : EightWindows{second, first};
}

}  // namespace

void FlatWindow::prepare() noexcept {
  Short8 least = all8(32767), most = {}, holes = {}, sign = {}, inverted = {};
  for (int y = 0; y < 8; ++y) {
    const auto l = reinterpret_cast<Short8>(load8(low + 8 * y));
    const auto h = reinterpret_cast<Short8>(load8(high + 8 * y));
    const Short8 hole = h == Short8{};
    holes += hole;
    sign |= l | h;
    inverted |= l > h;
    least = min8(least, l | (hole & all8(32767)));
    most = max8(most, h);
  }
  readings = 64 + sum8(holes);
  const bool wide = nonzero_bits8(reinterpret_cast<Count8>(sign < 0)) != 0;
  empty = nonzero_bits8(reinterpret_cast<Count8>(inverted)) != 0;
  const std::int32_t bottom = least8(least), top = most8(most);
  narrow = !wide && top - bottom <= 2 * kNarrow - 2;
  empty &= !wide;  // of levels beyond 32767 the signs say nothing
  comparable = !wide && top - bottom <= 2 * kComparable - 2;
  base = (bottom + top) / 2;
  if (!narrow) return;
  const Short8 from = all8(static_cast<std::int16_t>(base));
  for (int y = 0; y < 8; ++y) {
    const auto l = reinterpret_cast<Short8>(load8(low + 8 * y));
    const auto h = reinterpret_cast<Short8>(load8(high + 8 * y));
    store8(low_q8 + 8 * y, minus8((l - from) << 8, all8(128)));
    store8(high_q8 + 8 * y, minus8((h - from) << 8, all8(-127)));
  }
}

void load_window(const LevelWindow* windows, const std::uint16_t* depth, std::uint32_t width,
                 std::uint32_t columns, std::uint32_t rows, FlatWindow& window) noexcept {
  if (columns == 8 && rows == 8) {
    for (std::size_t y = 0; y < 8; ++y) {
      const EightWindows row = load_windows(windows, depth + y * width);
      store8(window.low + 8 * y, reinterpret_cast<Count8>(row.low));
      store8(window.high + 8 * y, reinterpret_cast<Count8>(row.high));
    }
  } else {
    for (std::uint32_t i = 0; i < 64; ++i) {
      const std::uint32_t x = i % 8, y = i / 8;
      const std::uint16_t d = x < columns && y < rows ? depth[std::size_t{y} * width + x] : 0;
      window.low[i] = windows[d].low;
      window.high[i] = windows[d].high;
    }
  }
  window.prepare();
}

bool fit_flat(const FlatWindow& window, const BlockPlane& foretold, const PlaneSteps& steps,
              std::int32_t last_level, FlatCode& code) noexcept {
  // Slopes a step off move a corner by 7 steps' worth at most: what is far from fitting never will.
  const std::int32_t hopeless = 7 * steps.slope + steps.offset;
  const auto attempt = [&](std::int32_t dx, std::int32_t dy, std::int32_t& gap) {
    if (std::abs(dx) > kMostSteps || std::abs(dy) > kMostSteps) return false;
    const BlockPlane tilted = BlockPlane::clamped(foretold.middle, foretold.dx + dx * steps.slope,
                                                  foretold.dy + dy * steps.slope, last_level);
    const Shifts shifts = allowed_shifts(window, tilted.surface(), hopeless);
    gap = shifts.least - shifts.most;
    if (gap > 0) return false;
    const std::int32_t offset = best_step(shifts, steps.offset);
    if (offset * steps.offset < shifts.least || offset * steps.offset > shifts.most) return false;
    const std::int32_t moved = foretold.middle + offset * steps.offset;
    if (std::abs(offset) > kMostSteps || moved < 256 || moved > 256 * last_level) return false;
    code = {offset, dx, dy};
    return true;
  };
  std::int32_t gap = 0;
  if (window.empty) return false;
  if (attempt(0, 0, gap)) return true;
  if (bent(window)) return false;
  const Slopes slopes = residual_slopes(window, foretold.surface());
  const std::int32_t dx = round_div(slopes.dx, steps.slope);
  const std::int32_t dy = round_div(slopes.dy, steps.slope);
  if (dx != 0 && dy != 0) {
    if (attempt(dx, 0, gap) || attempt(0, dy, gap)) return true;
  }
  if (attempt(dx, dy, gap)) return true;
  if (gap > hopeless) return false;
  constexpr std::int32_t kAround[8][2] = {{1, 0}, {-1, 0},  {0, 1},  {0, -1},
                                          {1, 1}, {-1, -1}, {1, -1}, {-1, 1}};
  for (const auto& [ox, oy] : kAround) {
    if (attempt(dx + ox, dy + oy, gap)) return true;
  }
  return false;
}

}  // namespace planecast
