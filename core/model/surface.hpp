// A surface of degree one as it travels: inverse depth, affine over undistorted rays.
#pragma once

#include <cstdint>

namespace planecast {

/// One over depth in steps of 2^-31 per depth count, the coordinate in which a plane seen by a
/// pinhole camera is affine: iv = a x + b y + c for the ray (x, y, 1). 1 .. 2^31.
inline constexpr int kInverseDepthBits = 31;

/// A plane: iv(x, y) = a x + b y + c with x, y the undistorted ray of a pixel. All three in
/// inverse-depth steps (kInverseDepthBits); multiples of 2^shift of the frame that holds it.
struct Surface {
  std::int32_t a = 0;
  std::int32_t b = 0;
  std::int32_t c = 0;

  /// Inverse depth at a ray given in Q27, in steps of 2^-31; may be zero or negative where the
  /// plane is behind the camera. |result| < 2^36.
  std::int64_t inverse_depth(std::int32_t x_q27, std::int32_t y_q27) const noexcept {
    return ((std::int64_t{a} * x_q27 + std::int64_t{b} * y_q27) >> 27) + c;
  }
  friend bool operator==(const Surface&, const Surface&) = default;
};

/// Largest coefficient magnitude on the wire, 30 bits: keeps inverse_depth() inside int64 with
/// room.
inline constexpr std::int32_t kMaxSurfaceCoefficient = (1 << 30) - 1;

}  // namespace planecast
