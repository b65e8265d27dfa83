// The k nearest neighbours of every point of a list, all found at once, once, for all steps that
// need them: points are put into buckets of neighbours, and a bucket's points share one walk.
#pragma once

#include <cstdint>
#include <limits>
#include <span>

#include "core/base/arena.hpp"
#include "core/base/status.hpp"
#include "core/cloud/sensor_frame.hpp"

namespace planecast {

/// Most neighbours that can be asked for.
inline constexpr std::uint32_t kMaxNeighbours = 128;

/// Exact search over a frame's points by a k-d tree of buckets of 16. What it gives is in *search
/// order*: points sorted so that neighbours in space are near in memory; source() leads back.
/// Distances are of float32 coordinates in float32; of equally near points some are taken, always
/// the same ones. One thread; memory from the arena at start: about 45 + 4 k bytes a point.
class PointNeighbours {
 public:
  void layout(Arena& arena, std::uint32_t max_points, std::uint32_t max_neighbours) noexcept;

  /// Finds the k nearest others of every point whose coordinates are finite and within +-reach
  /// (same unit as the points; 10^18 at most); the rest is left out. With k or fewer such points
  /// every point has all the others. kFrameTooLarge: more points than the layout; kBadConfig: k is
  /// 0 or above the layout, or reach is not in its range. O(n log n), about 0.6 us a point for
  /// k = 30; no allocation.
  Status search(std::span<const Point3f> points, std::uint32_t k, float reach) noexcept;

  /// Points in the search.
  std::uint32_t size() const noexcept { return size_; }
  /// Neighbours of every point: min(k, size() - 1), 0 for no points.
  std::uint32_t neighbours() const noexcept { return k_; }
  /// Places, in search order, of a point's neighbours, in no order; n < size().
  std::span<const std::uint32_t> of(std::uint32_t n) const noexcept {
    return ids_.subspan(std::size_t{n} * k_, k_);
  }
  /// Coordinates in search order, size() each.
  std::span<const float> x() const noexcept { return x_.first(size_); }
  std::span<const float> y() const noexcept { return y_.first(size_); }
  std::span<const float> z() const noexcept { return z_.first(size_); }
  /// Index in the span given to search(), by place in search order.
  std::span<const std::uint32_t> source() const noexcept { return source_.first(size_); }
  /// Mean distance of each point to its neighbours; 0 without any.
  std::span<const float> mean_distance() const noexcept { return mean_distance_.first(size_); }

 private:
  struct Entry {
    float at[3];
    std::uint32_t index;
  };
  struct Box {
    float low[4];
    float high[4];
  };
  /// A node, its buckets [first, last), and its diagonal.
  struct Crowd {
    std::uint32_t node, first, last;
    float reach;
  };
  class Query;

  void build(std::uint32_t node, std::uint32_t first, std::uint32_t last) noexcept;
  void gather(std::uint32_t node, std::uint32_t first, std::uint32_t last, const Box& around,
              float sq_reach) noexcept;
  void collect(const Crowd& crowd, std::uint32_t begin, std::uint32_t end, float reach) noexcept;
  void search_bucket(std::uint32_t bucket) noexcept;
  float search_point(std::uint32_t bucket, std::uint32_t n, float reach) noexcept;
  Crowd crowd_of(std::uint32_t bucket) const noexcept;

  std::span<Entry> entries_;
  std::span<Box> boxes_;  ///< of nodes: 1 is the root, 2 i and 2 i + 1 the halves of i
  std::span<float> x_, y_, z_;
  std::span<std::uint32_t> source_;
  std::span<std::uint32_t> ids_;
  std::span<float> mean_distance_;
  std::span<std::uint32_t> near_;  ///< buckets gathered for the one at hand
  std::span<float> near_box_[6];   ///< their boxes
  std::uint32_t near_count_ = 0;
  std::uint32_t size_ = 0, buckets_ = 0, k_ = 0;
  float last_reach_ = 0;  ///< distance of the last query's farthest neighbour
  std::uint32_t last_query_ = 0;
  std::uint32_t max_points_ = 0, max_k_ = 0;
};

}  // namespace planecast
