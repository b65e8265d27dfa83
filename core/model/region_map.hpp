// What segmentation hands to fitting: moments of every 8 x 8 cell and the region it is in. Spans
// over memory of the segmenter, valid until its next frame.
#pragma once

#include <cstdint>
#include <span>

#include "core/model/frame_model.hpp"
#include "core/model/plane_sums.hpp"
#include "core/model/quadric_sums.hpp"

namespace planecast {

/// One cell of 8 x 8 pixels, by moments about its own middle: floats are exact enough there, and
/// no sum cancels. x, y: rays; w: inverse depth in steps of 2^-31 per count.
struct Cell {
  float n = 0;                   ///< readings
  float x = 0, y = 0, w = 0;     ///< their means
  float xx = 0, xy = 0, yy = 0;  ///< mean products of x and y about their means
  float a = 0, b = 0;            ///< slopes of its own plane
  float own = 0;                 ///< mean squared distance from its own plane [steps^2]
  float variance = 0;            ///< noise variance of one reading [steps^2]
  bool flat = false;             ///< enough readings to start a region
  bool usable = false;           ///< enough readings to join one

  /// Mean squared distance of the readings from a surface that has the value `at` and these slopes
  /// at the cell's middle.
  float mean_square(float at, float slope_x, float slope_y) const noexcept {
    const float d = w - at, da = a - slope_x, db = b - slope_y;
    return own + d * d + da * da * xx + 2 * da * db * xy + db * db * yy;
  }
};

/// What a cell's residual may be in a region at all, in noise variances. Less loses points of real
/// sensors, whose noise is more than their model says.
inline constexpr float kMostCellResidual = 9;

/// Residual of a cell from a surface, in noise variances (mean square of a reading).
inline float cell_residual(const Cell& cell, const FloatSurface& s) noexcept {
  const double x = double{cell.x}, y = double{cell.y};
  const double bend = s.d * double{cell.xx} + s.e * double{cell.xy} + s.f * double{cell.yy};
  return cell.mean_square(static_cast<float>(s.at(x, y) + bend),
                          static_cast<float>(s.slope_x(x, y)),
                          static_cast<float>(s.slope_y(x, y))) /
         cell.variance;
}

/// The cell's readings as running sums, each counting by one over its noise variance.
inline PlaneSums plane_sums(const Cell& cell) noexcept {
  const double weight = double{cell.n} / double{cell.variance};
  const double x = double{cell.x}, y = double{cell.y}, w = double{cell.w};
  const double xx = double{cell.xx}, xy = double{cell.xy}, yy = double{cell.yy};
  const double a = double{cell.a}, b = double{cell.b};
  const double xw = a * xx + b * xy, yw = a * xy + b * yy;
  PlaneSums out;
  out.n = weight;
  out.x = weight * x;
  out.y = weight * y;
  out.w = weight * w;
  out.xx = weight * (xx + x * x);
  out.xy = weight * (xy + x * y);
  out.yy = weight * (yy + y * y);
  out.xw = weight * (xw + x * w);
  out.yw = weight * (yw + y * w);
  out.ww = weight * (double{cell.own} + a * xw + b * yw + w * w);
  return out;
}

/// The same for degree two.
inline void add_cell(QuadricSums& sums, const Cell& cell) noexcept {
  sums.add_patch({double{cell.n} / double{cell.variance}, double{cell.x}, double{cell.y},
                  double{cell.w}, double{cell.xx}, double{cell.xy}, double{cell.yy}, double{cell.a},
                  double{cell.b}, double{cell.own}});
}

/// Regions of a frame: cells row-major, cells_wide * cells_high = ceil(w/8) * ceil(h/8).
struct RegionMap {
  std::uint32_t cells_wide = 0, cells_high = 0;
  std::span<const Cell> cells;
  std::span<std::uint8_t> labels;  ///< 0 none, 1 .. regions; fitting may split regions in place
  int regions = 0;                 ///< at most kMaxSurfaces
  std::uint64_t curved = 0;        ///< bit k: region k is of degree two
  float noise_factor = 1;          ///< in the variances of the cells, over the noise model's
};

}  // namespace planecast
