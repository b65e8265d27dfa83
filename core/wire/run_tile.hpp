// A run tile: pixels that their neighbours foretell are counted, the rest say how far off they are.
// It takes less than half the time of the models and a quarter (lossless) to three times (coarse
// bounds) more bytes: the form for frames that run out of time. One walk that both halves
// instantiate: the encoder's Io writes each value and gives it back, the decoder's reads it
// (docs/wire-format.md, "Run tile").
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <type_traits>

#include "core/predict/pixel_row.hpp"
#include "core/wire/symbol_model.hpp"
#include "core/wire/tile_syntax.hpp"

namespace planecast {

/// What a symbol stands for: a number from `from` on that `bits` more tell.
struct NumberClass {
  std::uint32_t from;
  int bits;
};

/// Lengths of runs, symbols 0 .. 14; the last symbol is a run to the end of the tile.
inline constexpr int kRunToEnd = 15;
inline constexpr NumberClass kRunClass[kRunToEnd] = {
    {0, 0},  {1, 0},  {2, 0},  {3, 0},  {4, 0},   {5, 0},    {6, 1},    {8, 2},
    {12, 3}, {20, 4}, {36, 5}, {68, 6}, {132, 8}, {388, 12}, {4484, 22}};

/// Steps of a pixel that was not foretold. Symbol 0 is a hole (no step, where a hole was foretold),
/// 2 i + 1 and 2 i + 2 are class i upwards and downwards, the last the count itself.
inline constexpr int kMissClasses = 7;
inline constexpr int kMissCount = 15;
inline constexpr NumberClass kMissClass[kMissClasses] = {{1, 0}, {2, 0},  {3, 1},  {5, 2},
                                                         {9, 3}, {17, 4}, {33, 16}};

/// Adaptive state of one run tile.
struct RunModels {
  SymbolModel run[2][3];   ///< by what is foretold (hole, reading) and the last miss
  SymbolModel miss[2][3];  ///< likewise
};

/// Io: int symbol(SymbolModel&, int), uint32 raw(uint32, int bits), bool failed(), and kReads, true
/// where pixels are written. Memory is the caller's; nothing is allocated.
template <class Io>
class RunTile {
 public:
  using Depth = std::conditional_t<Io::kReads, std::uint16_t, const std::uint16_t>;

  /// `rows`: two or more, of this tile alone.
  RunTile(Io& io, const CodingTables& tables, const TileRect& rect,
          std::span<PixelRow> rows) noexcept
      : io_(io),
        tables_(tables),
        rect_(rect),
        span_(tile_span(tables.config->camera, rect)),
        rows_(rows) {
    clear_rows(rows, rect.bw);
  }

  /// Codes or decodes all pixels of the rectangle in `depth`, a whole image. kBadSymbol: a level
  /// that is none, or a run beyond the tile; no encoder writes them.
  Status walk(std::span<Depth> depth, std::uint32_t& points) noexcept {
    left_ = (span_.u1 - span_.u0) * (span_.v1 - span_.v0);
    Status status = Io::kReads ? read_run() : Status::kOk;
    for (std::uint32_t v = span_.v0; v < span_.v1 && status == Status::kOk && !io_.failed(); ++v) {
      Depth* row = depth.data() + std::size_t{v} * tables_.config->camera.width + span_.u0;
      for (std::uint32_t bx = 0; bx < rect_.bw && status == Status::kOk; ++bx)
        status = walk_segment(v, bx, row, points);
    }
    if (!Io::kReads && run_ > 0) io_.symbol(run_model(), kRunToEnd);
    return status;
  }

 private:
  /// Levels around a pixel, 0 for a hole.
  struct Around {
    std::int32_t left, above, foretold;
  };

  /// Eight pixels of one row, within one block. What the loop uses is copied first: a store may
  /// change anything in memory, as far as a compiler knows.
  Status walk_segment(std::uint32_t v, std::uint32_t bx, Depth* row,
                      std::uint32_t& points) noexcept {
    const std::uint32_t parity = (v - span_.v0) & 1U, x0 = bx * 8;
    std::uint16_t* here = rows_[parity].level + PixelRow::kBorder + x0;
    const std::uint16_t* above = rows_[1 - parity].level + PixelRow::kBorder + x0;
    Depth* depth = row + x0;
    const LevelTable levels = *tables_.levels;
    ray_class_ = tables_.bounds->ray_class(rect_.bx + bx, v / 8);
    std::uint32_t run = run_, found = 0;
    const int columns = static_cast<int>(std::min(8U, span_.u1 - span_.u0 - x0));
    std::int32_t level = here[-1];
    for (int x = 0; x < columns; ++x) {
      const Around around{level, above[x], foretell(level, above[x], above[x - 1])};
      level = around.foretold;
      if constexpr (Io::kReads) {
        depth[x] = levels.depth(static_cast<std::uint32_t>(level));
        --left_;
        if (run > 0) {
          --run;
        } else {
          if (!read_miss(around, level, depth[x])) return Status::kBadSymbol;
          if (const Status status = read_run(); status != Status::kOk) return status;
          run = run_;
        }
      } else if (holds(level, depth[x])) [[likely]] {
        ++run;
      } else {
        level = write_miss(run, around, depth[x]);
        run = 0;
      }
      here[x] = static_cast<std::uint16_t>(level);
      found += level != 0 ? 1U : 0U;
    }
    run_ = run;
    points += found;
    return Status::kOk;
  }

  /// Median of left, above and left + above - above-left; a hole where one of the two is, unless
  /// above-left is as well.
  static std::int32_t foretell(std::int32_t l, std::int32_t u, std::int32_t ul) noexcept {
    const std::int32_t low = std::min(l, u), high = std::max(l, u);
    const std::int32_t median = std::max(low, std::min(high, l + u - ul));
    return (low == 0) & (ul != 0) ? 0 : median;
  }

  /// Whether a level, 0 for a hole, is within the bound of a reading, 0 for none. Encoder only.
  bool holds(std::int32_t level, std::uint16_t depth) const noexcept {
    const LevelWindow window = tables_.bounds->windows(ray_class_)[depth];
    return (level >= window.low) & (level <= window.high);
  }

  /// Where the steps of a miss begin: at a level nearby where a hole was foretold.
  std::int32_t origin(const Around& around) const noexcept {
    if (around.foretold != 0) return around.foretold;
    if (around.left != 0) return around.left;
    return around.above != 0 ? around.above : last_level_;
  }
  std::int32_t step_at(std::int32_t level) const noexcept {
    return 2 * tables_.bounds->half_widths(ray_class_)[level] + 1;
  }

  static std::int32_t rounded(std::int32_t away, std::int32_t step) noexcept {
    return (away + (away < 0 ? -step / 2 : step / 2)) / step;
  }

  SymbolModel& run_model() noexcept { return models_.run[after_reading_][last_miss_]; }

  void missed(std::int32_t level, int size) noexcept {
    after_reading_ = level != 0 ? 1 : 0;
    if (level != 0) last_level_ = level;
    last_miss_ = size;
  }

  /// Writes the run before a reading or hole that was not foretold, and that.
  [[gnu::noinline]] std::int32_t write_miss(std::uint32_t run, const Around& around,
                                            std::uint16_t depth) noexcept {
    write_run(run);
    SymbolModel& model = models_.miss[around.foretold != 0 ? 1 : 0][last_miss_];
    if (depth == 0) {
      io_.symbol(model, 0);
      missed(0, 0);
      return 0;
    }
    const std::int32_t from = origin(around), step = step_at(from);
    const std::int32_t own = tables_.levels->nearest(depth), away = own - from;
    const std::int32_t steps = step == 1 ? away : rounded(away, step);
    const std::int32_t level = from + steps * step;
    const bool codable = holds(level, depth) && (steps != 0 || around.foretold == 0);
    if (!codable) {
      io_.symbol(model, kMissCount);
      io_.raw(depth, 16);
      missed(own, 2);
      return own;
    }
    const auto size = static_cast<std::uint32_t>(std::abs(steps));
    const int n =
        size == 0 ? 0 : std::min(static_cast<int>(std::bit_width(size - 1)) + 1, kMissClasses);
    io_.symbol(model, n == 0 ? 0 : 2 * n - (steps > 0 ? 1 : 0));
    if (n > 0) number(kMissClass[n - 1], size);
    missed(level, std::min(n, 2));
    return level;
  }

  /// False for a level that is none.
  [[gnu::noinline]] bool read_miss(const Around& around, std::int32_t& level,
                                   std::uint16_t& depth) noexcept {
    const int symbol = io_.symbol(models_.miss[around.foretold != 0 ? 1 : 0][last_miss_], 0);
    if (symbol == kMissCount) {
      depth = static_cast<std::uint16_t>(io_.raw(0, 16));
      level = tables_.levels->nearest(depth);
      missed(level, 2);
      return level != 0;
    }
    if (symbol == 0 && around.foretold != 0) {
      level = depth = 0;
      missed(0, 0);
      return true;
    }
    const int n = (symbol + 1) / 2;
    const auto size = n > 0 ? static_cast<std::int32_t>(number(kMissClass[n - 1], 0)) : 0;
    const std::int32_t from = origin(around);
    level = from + (symbol % 2 != 0 ? size : -size) * step_at(from);
    if (level < 1 || level >= static_cast<std::int32_t>(tables_.levels->count())) return false;
    depth = tables_.levels->depth(static_cast<std::uint32_t>(level));
    missed(level, std::min(n, 2));
    return true;
  }

  void write_run(std::uint32_t run) noexcept {
    int n = 0;
    while (n + 1 < kRunToEnd && run >= kRunClass[n + 1].from) ++n;
    io_.symbol(run_model(), n);
    number(kRunClass[n], run);
  }

  Status read_run() noexcept {
    if (left_ == 0) return Status::kOk;
    const int symbol = io_.symbol(run_model(), 0);
    if (symbol == kRunToEnd) {
      run_ = left_;
      return Status::kOk;
    }
    run_ = number(kRunClass[symbol], 0);
    return run_ < left_ ? Status::kOk : Status::kBadSymbol;
  }

  std::uint32_t number(const NumberClass& from, std::uint32_t value) noexcept {
    const std::uint32_t rest = value - from.from;
    const int high = std::max(from.bits - 16, 0), low = from.bits - high;
    const std::uint32_t top = high > 0 ? io_.raw(rest >> 16U, high) << 16U : 0;
    return from.from + top + (low > 0 ? io_.raw(rest & ((1U << low) - 1U), low) : 0);
  }

  Io& io_;
  const CodingTables& tables_;
  TileRect rect_;
  TileSpan span_;
  std::span<PixelRow> rows_;
  RunModels models_;
  std::uint32_t run_ = 0;        ///< pixels as foretold: so far, or still to come
  std::uint32_t left_ = 0;       ///< pixels of the tile still to come; decoder only
  std::int32_t last_level_ = 1;  ///< of the reading that was not foretold last
  int after_reading_ = 0;        ///< whether the last miss was a reading
  int last_miss_ = 0;            ///< its class: 0 none, 1, 2 for more
  std::uint8_t ray_class_ = 0;
};

}  // namespace planecast
