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
      for (std::size_t s = 0; seen > 0 && s < 16; ++s)
        all_[i][s] += input_[i][s] * std::min(seen, kMostOfAnInput) / seen;
      input_[i] = {};
    }
  }

  /// The mean of context `i`, drawn a little to an even distribution; old enough to be kept where
  /// it is known.
  SymbolModel start(std::size_t i) const {
    constexpr double kEven = 0.3, kKnown = 20;
    double seen = 0, below = 0;
    for (const double c : all_[i]) seen += c;
    SymbolModel out;
    out.bounds[0] = static_cast<std::int16_t>(seen < kKnown ? 0 : 12);
    for (std::size_t s = 1; s < 16; ++s) {
      below += (all_[i][s - 1] + kEven) / (seen + 16 * kEven);
      const long floor_of_all = 8 * static_cast<long>(s);  // every symbol keeps 8 of 32768
      out.bounds[s] = static_cast<std::int16_t>(std::lround(below * (32768 - 128)) + floor_of_all);
    }
    return out;
  }

 private:
  using Counts = std::array<double, 16>;
  static constexpr double kMostOfAnInput = 500;

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
    const PixelPrediction p = predict_pixel(around, place, fallback_ != 0 ? fallback_ : level);
    const ResidualContext context = residual_context(around, p.level);
    const std::int32_t residual = ((level - p.level) ^ context.turned) - context.turned;
    const bool near =
        std::abs(residual) <= kMostNear && levels.depth(static_cast<std::uint32_t>(level)) == depth;
    ++input_[context.model][near ? residual_symbol(residual).symbol : kFarSymbol];
    keep_residual(row, around.at, p, level);
    fallback_ = level;
  }

  std::vector<PixelRow> rows_ = std::vector<PixelRow>(3);
  std::vector<Counts> input_ = std::vector<Counts>(kResidualContexts);
  std::vector<Counts> all_ = std::vector<Counts>(kResidualContexts);
  std::int32_t fallback_ = 0;
};

}  // namespace planecast
