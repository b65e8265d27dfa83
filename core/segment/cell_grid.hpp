// Moments of every 8 x 8 cell of a depth image over undistorted rays and inverse depth, with the
// noise a reading has there: after this pass segmentation and fitting never touch pixels.
#pragma once

#include <cstdint>
#include <span>

#include "core/base/arena.hpp"
#include "core/base/status.hpp"
#include "core/model/region_map.hpp"
#include "core/model/stream_config.hpp"
#include "core/sensor/ray_table.hpp"

namespace planecast {

/// Noise of an inverse depth: what one standard deviation (or, finer, one level of the sensor)
/// is worth in steps of 2^-31 per count.
class InverseNoise {
 public:
  InverseNoise() noexcept = default;

  /// Lattice and stereo: uniform; time of flight: sigma_z / z^2; unknown without lattice: 0.002 z^2
  /// [m], as of a stereo camera.
  explicit InverseNoise(const StreamConfig& config) noexcept;

  /// Sigma at an inverse depth `iv` > 0.
  double sigma(double iv) const noexcept { return uniform_ + quadratic_ * iv * iv; }

 private:
  double uniform_ = 1;
  double quadratic_ = 0;
};

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
  std::span<const Cell> cells() const noexcept { return cells_.first(std::size_t{wide_} * high_); }

 private:
  void measure_cells(const RayTable& rays, std::span<const std::uint16_t> depth,
                     const InverseNoise& noise) noexcept;
  double found_noise() const noexcept;

  std::span<Cell> cells_;
  std::span<float> columns_;  ///< of each column: its ray's x from its cell's fifth column
  std::uint32_t wide_ = 0, high_ = 0;
};

}  // namespace planecast
