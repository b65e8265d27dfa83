// Delaunay triangulation in the plane, exact: coordinates are integers, predicates have no
// rounding.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace planecast::baselines {

/// A point of the plane; |x| and |y| at most kMostCoordinate.
struct Point2i {
  std::int64_t x = 0, y = 0;
};
inline constexpr std::int64_t kMostCoordinate = 1 << 20;

/// Bowyer and Watson's insertion, points found by walking. Points that are equal to an earlier one
/// are left out of the triangles. Triangles of the convex hull whose circle is larger than 2^26 may
/// be missing: three points of the frame stand that far out.
class Delaunay {
 public:
  explicit Delaunay(const std::vector<Point2i>& points);

  /// Triangles as places in `points`, anticlockwise, always in the same order for the same points.
  const std::vector<std::array<std::uint32_t, 3>>& triangles() const { return triangles_; }

  /// The triangle that holds `p`, on its border included; where none does, one that lies on the
  /// way to it; -1 when there are no triangles. Walks from the last one found.
  int find(const Point2i& p);

 private:
  struct Face {
    std::array<std::uint32_t, 3> corner;
    std::array<int, 3> next;  // face behind the side opposite to the corner, -1: none
    bool alive;
  };

  int walk(const Point2i& p);
  void insert(std::uint32_t vertex);
  bool in_circle(const Face& face, const Point2i& p) const;

  std::vector<Point2i> points_;  // the frame's three last
  std::vector<Face> faces_;
  std::vector<std::array<std::uint32_t, 3>> triangles_;
  std::vector<int> number_;  // of a face among the triangles, -1: touches the frame
  int last_ = 0;
};

}  // namespace planecast::baselines
