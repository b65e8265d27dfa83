// What segmentation hands to fitting: running sums of every 8 x 8 cell and the region it is in.
// Spans over memory of the segmenter, valid until its next frame.
#pragma once

#include <cstdint>
#include <span>

#include "core/model/frame_model.hpp"
#include "core/model/plane_sums.hpp"

namespace planecast {

/// One cell of 8 x 8 pixels.
struct Cell {
  PlaneSums sums;          ///< unweighted, over its readings
  float variance = 0;      ///< noise variance of one reading, in squared inverse-depth steps
  float own_residual = 0;  ///< mean squared residual of its own plane, in noise variances
  bool flat = false;       ///< enough readings for a plane of its own
  bool usable = false;     ///< enough readings to join a region
};

/// Regions of a frame: cells row-major, cells_wide * cells_high = ceil(w/8) * ceil(h/8).
struct RegionMap {
  std::uint32_t cells_wide = 0, cells_high = 0;
  std::span<const Cell> cells;
  std::span<std::uint8_t> labels;  ///< 0 none, 1 .. regions; fitting may split regions in place
  int regions = 0;                 ///< at most kMaxSurfaces
};

}  // namespace planecast
