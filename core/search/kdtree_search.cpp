#include "core/search/kdtree_search.hpp"

#include <cmath>
#include <nanoflann.hpp>
#include <vector>

namespace planecast {
namespace {

constexpr std::size_t kLeafSize = 12;  // fastest of 8..32 on VGA depth clouds

bool finite(const Point3f& p) noexcept {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

/// What nanoflann asks of a point container.
struct FinitePoints {
  std::vector<Point3f> points;
  std::vector<std::uint32_t> source_index;  // of points[i], in the caller's span

  std::size_t kdtree_get_point_count() const { return points.size(); }
  double kdtree_get_pt(std::size_t i, std::size_t axis) const {
    const Point3f& p = points[i];
    return axis == 0 ? p.x : axis == 1 ? p.y : p.z;
  }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

/// Result set of nanoflann that keeps the k best in the caller's span, ordered by distance and
/// then by index, so that the answer does not depend on the order of the walk.
class BestK {
 public:
  using DistanceType = double;

  explicit BestK(std::span<Neighbour> out) noexcept : out_(out) {}

  std::size_t size() const noexcept { return count_; }
  bool full() const noexcept { return count_ == out_.size(); }

  /// Just above the worst distance kept: nanoflann takes only what is strictly below.
  double worstDist() const noexcept {
    if (!full()) return std::numeric_limits<double>::infinity();
    return std::nextafter(out_.back().sq_dist, std::numeric_limits<double>::infinity());
  }

  bool addPoint(double sq_dist, std::uint32_t index) noexcept {
    const auto before = [&](const Neighbour& other) {
      return sq_dist < other.sq_dist || (sq_dist == other.sq_dist && index < other.index);
    };
    if (full() && !before(out_.back())) return true;
    std::size_t place = full() ? count_ - 1 : count_++;
    for (; place > 0 && before(out_[place - 1]); --place) out_[place] = out_[place - 1];
    out_[place] = {index, sq_dist};
    return true;
  }

 private:
  std::span<Neighbour> out_;
  std::size_t count_ = 0;
};

using Metric = nanoflann::L2_Simple_Adaptor<double, FinitePoints, double, std::uint32_t>;
using Index = nanoflann::KDTreeSingleIndexAdaptor<Metric, FinitePoints, 3, std::uint32_t>;

FinitePoints keep_finite(std::span<const Point3f> points) {
  FinitePoints kept;
  kept.points.reserve(points.size());
  kept.source_index.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!finite(points[i])) continue;
    kept.points.push_back(points[i]);
    kept.source_index.push_back(static_cast<std::uint32_t>(i));
  }
  return kept;
}

}  // namespace

struct KdTreeSearch::Tree {
  explicit Tree(std::span<const Point3f> cloud)
      : data(keep_finite(cloud)),
        index(3, data, nanoflann::KDTreeSingleIndexAdaptorParams(kLeafSize)) {}

  FinitePoints data;
  Index index;
};

KdTreeSearch::KdTreeSearch(std::span<const Point3f> points)
    : tree_(std::make_unique<Tree>(points)) {}
KdTreeSearch::~KdTreeSearch() = default;
KdTreeSearch::KdTreeSearch(KdTreeSearch&&) noexcept = default;
KdTreeSearch& KdTreeSearch::operator=(KdTreeSearch&&) noexcept = default;

std::size_t KdTreeSearch::size() const noexcept {
  return tree_->data.points.size();
}

Neighbour KdTreeSearch::nearest(const Point3f& query) const noexcept {
  Neighbour best;
  knn(query, {&best, 1});
  return best;
}

std::size_t KdTreeSearch::knn(const Point3f& query, std::span<Neighbour> out) const noexcept {
  if (out.empty() || size() == 0 || !finite(query)) return 0;
  const double position[3] = {query.x, query.y, query.z};
  BestK best(out);
  tree_->index.findNeighbors(best, position, nanoflann::SearchParams());
  // source_index grows with i, so the order among equals is the same in both numberings.
  for (Neighbour& n : out.first(best.size())) n.index = tree_->data.source_index[n.index];
  return best.size();
}

}  // namespace planecast
