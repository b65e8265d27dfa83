// The undistorted ray (x, y, 1) of every pixel in Q4.27, computed from a CameraModel by integers
// only: both ends of a stream hold the same table to the last bit (docs/wire-format.md, "Rays").
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/base/status.hpp"
#include "core/sensor/camera.hpp"

namespace planecast {

constexpr double kRayUnit = 1.0 / 134217728.0;  ///< of a ray's coordinate: 2^-27

/// Rays of one camera; points into storage owned by the caller. Values within +-kMaxRay.
/// separable (no distortion): x_q27 has width entries, y_q27 height entries;
/// otherwise both have width * height entries, row-major.
struct RayTable {
  std::uint16_t width = 0, height = 0;
  bool separable = true;
  std::span<const std::int32_t> x_q27;
  std::span<const std::int32_t> y_q27;

  /// x of the ray of pixel (u, v), Q27; u < width, v < height, unchecked.
  std::int32_t x(std::uint32_t u, std::uint32_t v) const noexcept {
    return x_q27[separable ? u : std::size_t{v} * width + u];
  }
  /// y of the ray of pixel (u, v), Q27; u < width, v < height, unchecked.
  std::int32_t y(std::uint32_t u, std::uint32_t v) const noexcept {
    return y_q27[separable ? v : std::size_t{v} * width + u];
  }
};

/// int32 entries of storage that build_ray_table needs: width + height, or 2 * width * height.
std::size_t ray_table_entries(const CameraModel& camera) noexcept;

/// Fills `storage` (at least ray_table_entries long, must outlive `out`) and points `out` into it.
/// No allocation. Without distortion a few microseconds; with it about 0.3 us a pixel (0.1 s for
/// 640 x 480), so call it once per camera, not per frame.
/// kOk; kOutOfArena: storage too short; kFieldRange: a camera field is out of range, or the
/// distortion cannot be undone at some pixel (no convergence to 2^-20, or the lens model folds).
Status build_ray_table(const CameraModel& camera, std::span<std::int32_t> storage,
                       RayTable& out) noexcept;

}  // namespace planecast
