// Flags readings that stand alone: the statistical outlier filter of the point-cloud world on the
// sensor's own grid, where neighbours cost no search. Flags only; the caller decides who drops.
#pragma once

#include <cstdint>
#include <span>

#include "core/base/arena.hpp"
#include "core/base/status.hpp"

namespace planecast {

struct OutlierOptions {
  double deviations = 3.0;  ///< cut = mean + this many standard deviations of the frame; >= 0
};

struct OutlierCounts {
  std::uint32_t readings = 0;
  std::uint32_t outliers = 0;  ///< isolated ones included
  std::uint32_t isolated = 0;  ///< readings without a valid neighbour among the eight
};

/// Makes readings outside [min_count, max_count] into holes; returns how many. In place; 0.1 ms for
/// 640 x 480.
std::uint32_t apply_range_gate(std::span<std::uint16_t> depth, std::uint16_t min_count,
                               std::uint16_t max_count) noexcept;

/// Zeroes flagged readings; returns how many. `flags` as OutlierFilter::process fills them.
std::uint32_t drop_flagged(std::span<std::uint16_t> depth,
                           std::span<const std::uint8_t> flags) noexcept;

/// The distance of a reading is the mean over the four directions of the grid of |difference in
/// depth| to the nearer of the two opposite neighbours, relative to its depth: on a straight edge
/// each direction has a neighbour on the reading's own side, so edges are kept, and far readings,
/// which lie further apart, are judged as near ones. One thread; deterministic.
class OutlierFilter {
 public:
  /// Takes memory (4 bytes a pixel and three rows) for frames up to this size, while starting.
  void layout(Arena& arena, std::uint32_t max_width, std::uint32_t max_height) noexcept;

  /// Sets flags[i] = 1 for outliers, else 0 (both spans width * height, row-major; depth in counts,
  /// 0 = no reading). kWrongSize: sizes disagree; kFrameTooLarge: beyond the layout. O(pixels),
  /// about 0.8 ms for 640 x 480.
  Status process(std::span<const std::uint16_t> depth, std::uint32_t width, std::uint32_t height,
                 const OutlierOptions& options, std::span<std::uint8_t> flags,
                 OutlierCounts& counts) noexcept;

 private:
  void measure_row(std::uint32_t width, const float* above, const float* here, const float* below,
                   float* out) noexcept;

  std::span<float> rows_;       ///< three rows of depth with borders of holes
  std::span<float> distances_;  ///< of each pixel; < 0 a hole, kIsolated without neighbours
  std::uint32_t max_width_ = 0;
};

}  // namespace planecast
