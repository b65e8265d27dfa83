// Moments of every 8 x 8 cell of a depth image over undistorted rays and inverse depth, with the
// noise a reading has there: after this pass segmentation and fitting never touch pixels.
#pragma once

#include <cstdint>
#include <span>

#include "core/base/arena.hpp"
#include "core/base/status.hpp"
#include "core/model/inverse_noise.hpp"
#include "core/model/region_map.hpp"
#include "core/model/stream_config.hpp"
#include "core/sensor/ray_table.hpp"

namespace planecast {

/// Cells of one frame. One thread. Memory: 52 bytes a cell and 4 bytes a column.
class CellGrid {
 public:
  /// Takes memory for frames of up to max_width x max_height pixels; call while starting.
  void layout(Arena& arena, std::uint32_t max_width, std::uint32_t max_height) noexcept;

  /// Measures `depth` (row-major counts, 0 = no reading; rays.width * rays.height long). The
  /// variances of the cells are those of the noise model, or of the noise found in the frame where
  /// that is larger: a sensor's neighbours share noise that no model states. About 0.4 ms for
  /// 640 x 480. kWrongSize: depth and rays differ; kFrameTooLarge: beyond the layout.
  Status process(const StreamConfig& config, const RayTable& rays,
                 std::span<const std::uint16_t> depth) noexcept;

  std::uint32_t cells_wide() const noexcept { return wide_; }
  std::uint32_t cells_high() const noexcept { return high_; }
  /// What the variances of the noise model were multiplied by in the last frame, at least 1.
  float noise_factor() const noexcept { return noise_factor_; }
  std::span<const Cell> cells() const noexcept { return cells_.first(std::size_t{wide_} * high_); }

 private:
  void measure_cells(const RayTable& rays, std::span<const std::uint16_t> depth,
                     const InverseNoise& noise) noexcept;
  double found_noise() const noexcept;

  std::span<Cell> cells_;
  std::span<float> columns_;  ///< of each column: its ray's x from its cell's fifth column
  std::uint32_t wide_ = 0, high_ = 0;
  float noise_factor_ = 1;
};

}  // namespace planecast
