// A surface before it is rounded for the wire, of degree one or two in the rays.
#pragma once

namespace planecast {

/// w(x, y) = a x + b y + c + d x^2 + e x y + f y^2, x and y the undistorted ray (x, y, 1), w the
/// inverse depth in steps of 2^-31 per count. A plane has d = e = f = 0.
struct FloatSurface {
  double a = 0, b = 0, c = 0, d = 0, e = 0, f = 0;

  double at(double x, double y) const noexcept {
    return x * (a + d * x + e * y) + y * (b + f * y) + c;
  }
  double slope_x(double x, double y) const noexcept { return a + 2 * d * x + e * y; }
  double slope_y(double x, double y) const noexcept { return b + e * x + 2 * f * y; }
  bool curved() const noexcept { return d != 0 || e != 0 || f != 0; }
};

}  // namespace planecast
