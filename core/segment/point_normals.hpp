// Normal and curvature of every point from the covariance of its neighbours (the paper's Eqs. 1 to
// 5).
#pragma once

#include <cstdint>
#include <span>

#include "core/base/status.hpp"
#include "core/search/point_neighbours.hpp"

namespace planecast {

/// Where normals go, one of each a point in search order.
struct PointNormals {
  std::span<float> x, y, z;    ///< unit vector, either sign; 0 where there is none
  std::span<float> curvature;  ///< least eigenvalue over their sum, 0..1/3; kNoCurvature without
};

/// Curvature of a point with fewer than three points to fit: it starts and joins no region.
inline constexpr float kNoCurvature = 1.0F;

/// Fills `normals` for the points of `cloud`: the eigenvector of the least eigenvalue of the
/// covariance of the point and those of its neighbours that are not in `removed` (1 where they are;
/// such points themselves get no normal). Points that are all equal have none either; of collinear
/// points any direction across the line is taken. kWrongSize: a span is not cloud.size() long.
/// About 0.25 us a point for 30 neighbours; no allocation.
Status estimate_normals(const PointNeighbours& cloud, std::span<const std::uint8_t> removed,
                        const PointNormals& normals) noexcept;

}  // namespace planecast
