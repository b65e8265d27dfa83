// A surface as it travels: inverse depth, of degree one or two in the undistorted ray.
#pragma once

#include <cstdint>

namespace planecast {

/// One over depth in steps of 2^-31 per depth count, the coordinate in which a plane seen by a
/// pinhole camera is affine: iv = a x + b y + c for the ray (x, y, 1). 1 .. 2^31.
inline constexpr int kInverseDepthBits = 31;

/// iv(x, y) = a x + b y + c + d x^2 + e x y + f y^2 with x, y the undistorted ray of a pixel; a
/// plane has d = e = f = 0. All six in inverse-depth steps (kInverseDepthBits); multiples of
/// 2^shift of the frame that holds it.
struct Surface {
  std::int32_t a = 0;
  std::int32_t b = 0;
  std::int32_t c = 0;
  std::int32_t d = 0;
  std::int32_t e = 0;
  std::int32_t f = 0;

  bool curved() const noexcept { return (d | e | f) != 0; }

  /// Inverse depth at a ray given in Q27, in steps of 2^-31; may be zero or negative where the
  /// surface is behind the camera. |result| < 2^39.
  std::int64_t inverse_depth(std::int32_t x_q27, std::int32_t y_q27) const noexcept {
    const std::int64_t plane = ((std::int64_t{a} * x_q27 + std::int64_t{b} * y_q27) >> 27) + c;
    return curved() ? plane + bend(x_q27, y_q27) : plane;
  }
  friend bool operator==(const Surface&, const Surface&) = default;

 private:
  // Products of rays in Q22: |x y| <= 64 leaves them 28 bits, and the sum fits 64.
  std::int64_t bend(std::int32_t x_q27, std::int32_t y_q27) const noexcept {
    const std::int64_t x = x_q27 >> 6, y = y_q27 >> 6;
    return (d * ((x * x) >> 20) + e * ((x * y) >> 20) + f * ((y * y) >> 20)) >> 22;
  }
};

/// Largest coefficient magnitude on the wire, 30 bits: keeps inverse_depth() inside int64 with
/// room.
inline constexpr std::int32_t kMaxSurfaceCoefficient = (1 << 30) - 1;

}  // namespace planecast
