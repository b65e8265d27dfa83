// Running sums of (1, x, y, w): all that a least-squares plane w = a x + b y + c needs, and that
// adding pixels, cells or regions keeps. Encoder half; plain doubles, no library.
#pragma once

#include "core/model/float_surface.hpp"

namespace planecast {

/// Weighted sums over readings. Value type; all calls O(1), no allocation.
struct PlaneSums {
  double n = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0, w = 0, xw = 0, yw = 0, ww = 0;

  /// Adds `other`, every reading of it counting `weight` times.
  void add(const PlaneSums& other, double weight = 1.0) noexcept {
    n += weight * other.n;
    x += weight * other.x;
    y += weight * other.y;
    xx += weight * other.xx;
    xy += weight * other.xy;
    yy += weight * other.yy;
    w += weight * other.w;
    xw += weight * other.xw;
    yw += weight * other.yw;
    ww += weight * other.ww;
  }

  /// The same readings with coordinates counted from (-x0, -y0, -w0).
  PlaneSums moved(double x0, double y0, double w0) const noexcept {
    PlaneSums out;
    out.n = n;
    out.x = x + n * x0;
    out.y = y + n * y0;
    out.w = w + n * w0;
    out.xx = xx + x0 * (2 * x + n * x0);
    out.yy = yy + y0 * (2 * y + n * y0);
    out.xy = xy + x0 * y + y0 * (x + n * x0);
    out.xw = xw + x0 * w + w0 * (x + n * x0);
    out.yw = yw + y0 * w + w0 * (y + n * y0);
    out.ww = ww + w0 * (2 * w + n * w0);
    return out;
  }

  /// Least-squares plane of the readings; false when they lie on one line (or there are none).
  bool solve(FloatSurface& out) const noexcept {
    if (n <= 0) return false;
    const double mx = x / n, my = y / n, mw = w / n;
    const double cxx = xx - mx * x, cxy = xy - mx * y, cyy = yy - my * y;
    const double cxw = xw - mx * w, cyw = yw - my * w;
    const double determinant = cxx * cyy - cxy * cxy;
    if (!(determinant > 1e-9 * cxx * cyy) || !(cxx > 0) || !(cyy > 0)) return false;
    out.a = (cxw * cyy - cyw * cxy) / determinant;
    out.b = (cyw * cxx - cxw * cxy) / determinant;
    out.c = mw - out.a * mx - out.b * my;
    return true;
  }

  /// Mean squared distance of the readings from a plane, in w; 0 for none.
  double mean_square(const FloatSurface& p) const noexcept {
    if (n <= 0) return 0;
    // About the means, so that large w does not cancel.
    const double mx = x / n, my = y / n, mw = w / n;
    const double cxx = xx - mx * x, cxy = xy - mx * y, cyy = yy - my * y;
    const double cxw = xw - mx * w, cyw = yw - my * w, cww = ww - mw * w;
    const double offset = mw - p.at(mx, my);
    const double spread =
        cww - 2 * (p.a * cxw + p.b * cyw) + p.a * p.a * cxx + p.b * p.b * cyy + 2 * p.a * p.b * cxy;
    return offset * offset + (spread > 0 ? spread / n : 0);
  }
};

}  // namespace planecast
