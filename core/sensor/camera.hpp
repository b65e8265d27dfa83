// The pinhole camera with Brown-Conrady distortion, twice: in doubles as people write it, and in
// the integers that travel in the key packet. Rays are computed from the integers only, so that
// both ends of a stream, whatever the machine, regenerate the same points.
#pragma once

#include <cstdint>

#include "core/base/status.hpp"
#include "core/cloud/sensor_frame.hpp"

namespace planecast {

/// Camera parameters as published or calibrated. Focal lengths and centre in pixels, pixel centres
/// at integer coordinates; distortion in OpenCV's order and meaning; depth counts to metres.
struct Intrinsics {
  double fx = 0, fy = 0, cx = 0, cy = 0;          ///< [px]
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0, k3 = 0;  ///< radial k, tangential p
  double metres_per_unit = 0.001;                 ///< [m] of one depth count
};

/// The same camera, wire-exact. Ranges: sizes 1..kMaxImageSide, unit_pm 1..kMaxUnitPm, fx_q16 and
/// fy_q16 > 0; check_camera() checks them all. Optical axes: x right, y down, z forward.
struct CameraModel {
  std::uint16_t width = 0, height = 0;   ///< [px]
  std::uint32_t fx_q16 = 0, fy_q16 = 0;  ///< [px / 65536]
  std::int32_t cx_q16 = 0, cy_q16 = 0;   ///< [px / 65536]
  std::int32_t k1_q24 = 0, k2_q24 = 0, p1_q24 = 0, p2_q24 = 0, k3_q24 = 0;
  std::uint64_t unit_pm = 0;  ///< [pm] of one depth count, 10^9 = 1 mm

  /// Whether any distortion coefficient is set; without, rays are separable in u and v.
  bool distorted() const noexcept { return (k1_q24 | k2_q24 | p1_q24 | p2_q24 | k3_q24) != 0; }
  /// Pixels of the image.
  std::uint32_t pixels() const noexcept { return std::uint32_t{width} * height; }

  friend bool operator==(const CameraModel&, const CameraModel&) = default;
};

inline constexpr std::uint64_t kMaxUnitPm = 1'000'000'000'000;  ///< 1 m
/// Largest |x| and |y| of a ray (x, y, 1): tan 82.9 degrees. Leaves sums of squares room in int64.
inline constexpr std::int32_t kMaxRay = 8;

/// Checks every field of a model, e.g. one that came from outside: kOk or kFieldRange. Integers
/// only; says nothing about the convergence of the distortion, which build_ray_table checks.
Status check_camera(const CameraModel& camera) noexcept;

/// Rounds parameters to the wire's integers. `width`, `height` in pixels, 1..16384; fx, fy > 0 and
/// no pixel more than 82 degrees off axis; unit 1 pm to 1 m. Cold path.
/// Errors: kBadConfig, naming the number and the mend.
Result<CameraModel> quantise(const Intrinsics& intrinsics, std::uint32_t width,
                             std::uint32_t height);

/// The doubles that the integers stand for, exactly.
Intrinsics to_intrinsics(const CameraModel& camera) noexcept;

}  // namespace planecast
