// The cube round a cloud that octrees halve, and points as Morton codes of its cells.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstring>

#include "bench/baselines/byte_io.hpp"

namespace planecast::baselines {

inline constexpr int kMostLevels = 21;  ///< three coordinates in 63 bits

/// A cube of `levels` halvings; travels as it is.
struct PointCube {
  float x = 0, y = 0, z = 0;  ///< least corner [m]
  double side = 0;            ///< [m]
  std::uint32_t levels = 0;

  double cell() const { return std::ldexp(side, -static_cast<int>(levels)); }
  /// Which cell of the finest level a coordinate lies in.
  std::uint32_t index(float value, float least) const {
    const double at = (double{value} - least) / cell();
    return static_cast<std::uint32_t>(std::clamp(at, 0.0, std::ldexp(1.0, int(levels)) - 1));
  }
};

/// The cube round the points: its least corner and its side, levels 0.
inline PointCube cube_round(const PointList& points) {
  PointCube cube;
  if (points.empty()) return cube;
  Point3f low = points[0], high = points[0];
  for (const Point3f& p : points) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  cube.x = low.x;
  cube.y = low.y;
  cube.z = low.z;
  cube.side = std::max({double{high.x} - low.x, double{high.y} - low.y, double{high.z} - low.z});
  return cube;
}

/// x, y, z interleaved, x highest: the children of a cell are its code * 8 + 0..7.
inline std::uint64_t morton(std::uint32_t x, std::uint32_t y, std::uint32_t z, int levels) {
  std::uint64_t code = 0;
  for (int bit = levels - 1; bit >= 0; --bit) {
    code = code << 3 | ((x >> bit & 1) << 2 | (y >> bit & 1) << 1 | (z >> bit & 1));
  }
  return code;
}

/// Centre of the cell of a code at `level` halvings.
inline Point3f cell_centre(const PointCube& cube, std::uint64_t code, int level) {
  double x = 0, y = 0, z = 0;
  const double size = std::ldexp(cube.side, -level);
  for (int bit = 0; bit < level; ++bit, code >>= 3) {
    x += static_cast<double>(code >> 2 & 1) * std::ldexp(size, bit);
    y += static_cast<double>(code >> 1 & 1) * std::ldexp(size, bit);
    z += static_cast<double>(code & 1) * std::ldexp(size, bit);
  }
  return {static_cast<float>(cube.x + x + size / 2), static_cast<float>(cube.y + y + size / 2),
          static_cast<float>(cube.z + z + size / 2)};
}

}  // namespace planecast::baselines
