// Moments of a cell's readings from sums over them, in floats about a middle of the cell's own.
#pragma once

#include <algorithm>

#include "core/model/region_map.hpp"

namespace planecast {

/// Sums of a cell's readings about a ray (x0, y0) and an inverse depth w0 of its own.
struct LocalSums {
  float n = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0, w = 0, xw = 0, yw = 0, ww = 0;
};

/// Moments from sums; false when the readings lie on one line.
inline bool set_moments(const LocalSums& s, Cell& cell) noexcept {
  const float share = 1 / s.n;
  const float mx = s.x * share, my = s.y * share, mw = s.w * share;
  cell.n = s.n;
  cell.x = mx;
  cell.y = my;
  cell.w = mw;
  cell.xx = s.xx * share - mx * mx;
  cell.xy = s.xy * share - mx * my;
  cell.yy = s.yy * share - my * my;
  const float xw = s.xw * share - mx * mw, yw = s.yw * share - my * mw;
  const float ww = std::max(0.0F, s.ww * share - mw * mw);
  const float square = cell.xx * cell.yy;
  const float determinant = square - cell.xy * cell.xy;
  cell.own = ww;
  if (!(determinant > 1e-4F * square) || !(square > 0)) return false;
  cell.a = (xw * cell.yy - yw * cell.xy) / determinant;
  cell.b = (yw * cell.xx - xw * cell.xy) / determinant;
  cell.own = std::max(0.0F, ww - cell.a * xw - cell.b * yw);
  return true;
}

}  // namespace planecast
