// What Morell 2014 and DT2016 share: planar patches as Delaunay triangles that each stand for a
// number of points; only the choice of vertices differs.
#pragma once

#include <functional>

#include "bench/baselines/plane_patches.hpp"

namespace planecast::baselines {

/// The side of the cells [m] of which each gives one vertex: the member of it that is farthest from
/// the patch's middle, so that the border stays.
using VertexPitch = std::function<double(const std::vector<Eigen::Vector2d>& members)>;

/// A patch: plane and axes as float32, vertices as two float32, points of each triangle as a
/// varint; triangles are not sent, the decoder triangulates again. Points on no patch: float32.
Bytes encode_triangles(const PointList& points, const VertexPitch& pitch);

/// As many points in each triangle as it stands for, uniform over it (PCG32 of one seed), on the
/// plane; then the points on no patch. Throws on bytes of another make.
PointList decode_triangles(const Bytes& bytes);

/// How many vertices a pitch gives.
std::size_t vertices_at(const std::vector<Eigen::Vector2d>& members, double pitch);

}  // namespace planecast::baselines
