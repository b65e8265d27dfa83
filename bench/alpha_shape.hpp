// The alpha shape of points in a plane, as pcl::ConcaveHull makes it: of the Delaunay triangles
// those whose circle is no larger than alpha. What the paper's files keep of a plane is its
// corners.
#pragma once

#include <span>

#include "bench/baselines/baseline.hpp"

namespace planecast::bench {

struct AlphaShape {
  std::size_t corners = 0;  ///< of all outlines, holes' too: a point on two of them counts twice
  double area_m2 = 0;
};

/// The shape of `points` [m], projected onto the plane of unit normal `n`; alpha in metres. Places
/// are rounded to 2^-21 of the points' extent. O(n log n), allocates.
AlphaShape alpha_shape(const baselines::PointList& points, const double (&n)[3], double alpha_m);

}  // namespace planecast::bench
