// Counts the residual symbols of lossless tiles by context: what train_models learns starts from.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

#include "core/predict/residual_context.hpp"
#include "core/wire/residual_models.hpp"
#include "core/wire/tile_syntax.hpp"
#include "core/wire/tile_unpack.hpp"

namespace planecast {

class ResidualCounts {
 public:
  /// Goes over a decoded tile as its decoder did. `labels` as TileTarget's.
  void add(const CodingTables& tables, const TileContent& content,
           std::span<const std::uint16_t> depth, std::span<const std::uint8_t> labels) {
    clear_rows(rows_, content.rect.bw);
    const CameraModel& camera = tables.config->camera;
    const TileSpan span = tile_span(camera, content.rect);
    fallback_ = 0;
    tiles_.push_back({.every_count = tables.levels->every_count(), .seen = {}});
    for (std::uint32_t v = span.v0; v < span.v1; ++v) {
      for (std::uint32_t i = 0; i < content.rect.bw; ++i) {
        const std::uint32_t u0 = span.u0 + 8 * i, u1 = std::min(u0 + 8, span.u1);
        PixelPlace place(tables.bounds->half_widths(0),
                         static_cast<std::int32_t>(tables.levels->count()) - 1);
        const std::uint8_t label = label_of(camera, labels, u0, u1, v / 8 * 8, span.v1);
        if (label != 0) {
          place.lie_on(block_surface(content.surface[label - 1U], *tables.rays, *tables.levels,
                                     content.rect.bx + i, v / 8),
                       v % 8);
        }
        for (std::uint32_t u = u0; u < u1; ++u, place.step_right())
          count(*tables.levels, TileRows(rows_, v - span.v0).around(u - span.u0), place,
                depth[std::size_t{v} * camera.width + u], rows_[(v - span.v0) % 3]);
      }
    }
  }

  /// Ends an input: one sensor's many symbols must not outvote the others.
  void end_input() {
    for (std::size_t i = 0; i < input_.size(); ++i) {
      double seen = 0;
      for (const double c : input_[i]) seen += c;
      for (std::size_t s = 0; seen > 0 && s < 16; ++s) {
        const double counts = input_[i][s] * std::min(seen, kMostOfAnInput) / seen;
        all_[1][i][s] += counts;
        if (!tiles_.back().every_count) all_[0][i][s] += counts;
      }
      input_[i] = {};
    }
  }

  /// Starts of a set: of sensors on a lattice what those said, of all others what all said.
  std::vector<SymbolModel> starts(bool every_count) const {
    std::vector<SymbolModel> models;
    for (const Counts& counts : all_[every_count ? 1 : 0]) models.push_back(start(counts));
    choose_ages(every_count, models);
    return models;
  }

 private:
  using Counts = std::array<double, 16>;
  static constexpr double kMostOfAnInput = 500;
  static constexpr int kModels = kShapeContexts + kErrorContexts;
  static constexpr std::array<std::int16_t, 6> kAges = {2, 6, 12, 16, 20, 24};

  struct Seen {
    std::uint16_t model[2];  ///< of the shape, and kShapeContexts + that of errors
    std::uint8_t symbol;
  };
  struct Tile {
    bool every_count;
    std::vector<Seen> seen;
  };

  // The mean of a context, drawn a little to an even distribution.
  static SymbolModel start(const Counts& counts) {
    constexpr double kEven = 0.3, kKnown = 20;
    double seen = 0, below = 0;
    for (const double c : counts) seen += c;
    if (seen < kKnown) return {};
    SymbolModel out;
    out.bounds[0] = kAges[2];
    for (std::size_t s = 1; s < 16; ++s) {
      below += (counts[s - 1] + kEven) / (seen + 16 * kEven);
      const long floor_of_all = 8 * static_cast<long>(s);  // every symbol keeps 8 of 32768
      out.bounds[s] = static_cast<std::int16_t>(std::lround(below * (32768 - 128)) + floor_of_all);
    }
    return out;
  }

  // Gives every known start the age with which it costs the tiles least: the older, the longer it
  // is kept.
  void choose_ages(bool every_count, std::vector<SymbolModel>& starts) const {
    std::vector<std::array<double, kAges.size()>> bits(starts.size());
    std::vector<SymbolModel> models;
    for (std::size_t a = 0; a < kAges.size(); ++a) {
      for (SymbolModel& m : starts) m.bounds[0] = m.bounds[0] != 0 ? kAges[a] : std::int16_t{0};
      for (const Tile& tile : tiles_) {
        if (tile.every_count && !every_count) continue;
        models = starts;
        for (const Seen& seen : tile.seen) {
          for (const std::uint16_t i : seen.model) {
            SymbolModel& m = models[i];
            bits[i][a] -= std::log2((m.high(seen.symbol) - m.low(seen.symbol)) / 32768.0);
            m.update(seen.symbol);
          }
        }
      }
    }
    for (std::size_t i = 0; i < starts.size(); ++i) {
      const auto least = std::min_element(bits[i].begin(), bits[i].end());
      if (starts[i].bounds[0] != 0)
        starts[i].bounds[0] = kAges[static_cast<std::size_t>(least - bits[i].begin())];
    }
  }

  static std::uint8_t label_of(const CameraModel& camera, std::span<const std::uint8_t> labels,
                               std::uint32_t u0, std::uint32_t u1, std::uint32_t v0,
                               std::uint32_t v_end) {
    for (std::uint32_t v = v0; v < std::min(v0 + 8, v_end); ++v) {
      for (std::uint32_t u = u0; u < u1; ++u) {
        if (labels[std::size_t{v} * camera.width + u] != 0)
          return labels[std::size_t{v} * camera.width + u];
      }
    }
    return 0;
  }

  void count(const LevelTable& levels, const Neighbourhood& around, const PixelPlace& place,
             std::uint16_t depth, PixelRow& row) {
    if (depth == 0) return row.set_hole(around.at);
    const std::int32_t level = levels.nearest(depth);
    // The first reading of a tile is its own fallback.
    const LosslessPrediction p =
        predict_lossless(around, place, fallback_ != 0 ? fallback_ : level, levels.every_count());
    const ResidualContext context = residual_context(around, p);
    const std::int32_t residual = ((level - p.level) ^ context.turned) - context.turned;
    const bool near =
        std::abs(residual) <= kMostNear && levels.depth(static_cast<std::uint32_t>(level)) == depth;
    const Seen seen{
        {static_cast<std::uint16_t>(context.shape),
         static_cast<std::uint16_t>(kShapeContexts + errors_context(around, p, context))},
        near ? residual_symbol(residual).symbol : std::uint8_t{kFarSymbol}};
    for (const std::uint16_t i : seen.model) ++input_[i][seen.symbol];
    tiles_.back().seen.push_back(seen);
    keep_residual(row, around.at, p, level);
    fallback_ = level;
  }

  std::vector<PixelRow> rows_ = std::vector<PixelRow>(3);
  std::vector<Counts> input_ = std::vector<Counts>(kModels);
  std::array<std::vector<Counts>, 2> all_ = {std::vector<Counts>(kModels),
                                             std::vector<Counts>(kModels)};
  std::vector<Tile> tiles_;
  std::int32_t fallback_ = 0;
};

}  // namespace planecast
