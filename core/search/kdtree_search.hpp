// Nearest points of a list of points by a k-d tree. Cold path: it allocates on build (the reference
// path of unorganised clouds, and the metrics). nanoflann stays behind the .cpp.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>

#include "core/cloud/sensor_frame.hpp"

namespace planecast {

/// A point found: its index in the span the tree was built from, and the squared distance [m^2].
/// When there is nothing to find, index is kNone and sq_dist infinite.
struct Neighbour {
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  std::uint32_t index = kNone;
  double sq_dist = std::numeric_limits<double>::infinity();
  bool found() const noexcept { return index != kNone; }
};

/// Exact nearest-neighbour search over points in metres, all of one frame of reference.
/// Distances are computed in double; of equally near points the one with the lowest index wins.
/// Once built it is never changed: any number of threads may search at the same time.
class KdTreeSearch {
 public:
  /// Copies the points (the span may go afterwards) and builds the tree: O(n log n) time, about
  /// 32 B of heap a point. Points with a coordinate that is not finite are left out; no points at
  /// all is a valid tree that finds nothing. Takes at most 2^32 - 1 points.
  explicit KdTreeSearch(std::span<const Point3f> points);
  ~KdTreeSearch();
  KdTreeSearch(KdTreeSearch&&) noexcept;
  KdTreeSearch& operator=(KdTreeSearch&&) noexcept;

  /// Number of finite points in the tree.
  std::size_t size() const noexcept;

  /// The point nearest to `query` [m]. Not found when the tree is empty or the query not finite.
  /// No allocation; O(log n) on average.
  Neighbour nearest(const Point3f& query) const noexcept;

  /// Writes the min(out.size(), size()) points nearest to `query` [m], nearest first, into `out`
  /// and returns how many they are (0 for a query that is not finite). A query that is one of the
  /// points finds itself first (or its copy with the lowest index). No allocation; O(k log n).
  std::size_t knn(const Point3f& query, std::span<Neighbour> out) const noexcept;

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

}  // namespace planecast
