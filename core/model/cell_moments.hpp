// Moments of a cell's readings from sums over them, in floats about a middle of the cell's own.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "core/model/region_map.hpp"

namespace planecast {

/// Sums of a cell's readings about a ray (x0, y0) and an inverse depth w0 of its own.
struct LocalSums {
  float n = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0, w = 0, xw = 0, yw = 0, ww = 0;

  /// One reading, by its distances from (x0, y0) and w0.
  void add(float dx, float dy, float dw) noexcept {
    n += 1;
    x += dx;
    y += dy;
    xx += dx * dx;
    xy += dx * dy;
    yy += dy * dy;
    w += dw;
    xw += dx * dw;
    yw += dy * dw;
    ww += dw * dw;
  }
};

/// 2^kInverseDepthBits: the inverse depth of one count.
inline constexpr float kInverseDepthOne = 2147483648.0F;

/// An inverse depth of a cell of `wide` x `high` pixels to count from: that of its first reading, 0
/// where there is none. `stride`: pixels from row to row.
inline float cell_origin(const std::uint16_t* depth, std::size_t stride, std::uint32_t wide,
                         std::uint32_t high) noexcept {
  for (std::uint32_t v = 0; v < high; ++v) {
    for (std::uint32_t u = 0; u < wide; ++u) {
      if (depth[v * stride + u] != 0)
        return kInverseDepthOne / static_cast<float>(depth[v * stride + u]);
    }
  }
  return 0;
}

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
