#include "core/search/point_neighbours.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/base/lanes.hpp"

namespace planecast {
namespace {

constexpr std::uint32_t kBucket = 16;
constexpr float kInfinity = std::numeric_limits<float>::infinity();
// Reaches come from sums of rounded distances: this much more is safe, and costs no hit.
constexpr float kMargin = 1.0001F;

std::uint32_t ceil_buckets(std::uint32_t points) noexcept {
  return (points + kBucket - 1) / kBucket;
}

std::uint32_t node_count(std::uint32_t buckets) noexcept {
  return 2 * std::bit_ceil(std::max(1U, buckets));
}

/// Where the buckets [first, last) of a node are cut in two.
std::uint32_t middle(std::uint32_t first, std::uint32_t last) noexcept {
  return (first + last + 1) / 2;
}

}  // namespace

void PointNeighbours::layout(Arena& arena, std::uint32_t max_points,
                             std::uint32_t max_neighbours) noexcept {
  max_points_ = max_points;
  max_k_ = std::min(max_neighbours, kMaxNeighbours);
  const std::uint32_t buckets = ceil_buckets(max_points);
  const std::size_t padded = std::size_t{buckets} * kBucket;
  entries_ = arena.take<Entry>(max_points);
  boxes_ = arena.take<Box>(node_count(buckets));
  x_ = arena.take<float>(padded);
  y_ = arena.take<float>(padded);
  z_ = arena.take<float>(padded);
  source_ = arena.take<std::uint32_t>(padded);
  ids_ = arena.take<std::uint32_t>(std::size_t{max_points} * max_k_);
  mean_distance_ = arena.take<float>(padded);
  near_ = arena.take<std::uint32_t>(buckets + 4);
  for (std::span<float>& side : near_box_) side = arena.take<float>(buckets + 4);
}

Status PointNeighbours::search(std::span<const Point3f> points, std::uint32_t k,
                               float reach) noexcept {
  size_ = buckets_ = k_ = 0;
  if (k == 0 || k > max_k_ || !(reach > 0) || reach > 1e18F) return Status::kBadConfig;
  if (points.size() > max_points_) return Status::kFrameTooLarge;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    const Point3f& p = points[i];
    const bool inside = std::abs(p.x) <= reach && std::abs(p.y) <= reach && std::abs(p.z) <= reach;
    if (inside) entries_[size_++] = {{p.x, p.y, p.z}, i};
  }
  if (size_ == 0) return Status::kOk;
  k_ = std::min(k, size_ - 1);
  buckets_ = ceil_buckets(size_);
  build(1, 0, buckets_);
  for (std::uint32_t n = 0; n < buckets_ * kBucket; ++n) {
    const bool real = n < size_;
    x_[n] = real ? entries_[n].at[0] : kInfinity;
    y_[n] = real ? entries_[n].at[1] : kInfinity;
    z_[n] = real ? entries_[n].at[2] : kInfinity;
    source_[n] = real ? entries_[n].index : 0;
  }
  if (k_ == 0) {
    mean_distance_[0] = 0;
    return Status::kOk;
  }
  last_reach_ = kInfinity;
  last_query_ = 0;
  for (std::uint32_t b = 0; b < buckets_; ++b) search_bucket(b);
  return Status::kOk;
}

// Halves are of whole buckets, so that only the very last one is not full.
void PointNeighbours::build(std::uint32_t node, std::uint32_t first, std::uint32_t last) noexcept {
  const std::uint32_t begin = first * kBucket, end = std::min(last * kBucket, size_);
  Float4 low = all4(kInfinity), high = all4(-kInfinity);
  for (std::uint32_t n = begin; n < end; ++n) {
    const Float4 at = load4(entries_[n].at);  // the index rides along in the fourth lane
    low = min4(low, at);
    high = max4(high, at);
  }
  Box& box = boxes_[node];
  store4(box.low, low);
  store4(box.high, high);
  if (last - first < 2) return;
  const float size[3] = {high[0] - low[0], high[1] - low[1], high[2] - low[2]};
  const int axis = size[0] >= size[1] && size[0] >= size[2] ? 0 : (size[1] >= size[2] ? 1 : 2);
  const std::uint32_t mid = middle(first, last);
  if (size[axis] > 0) {
    std::nth_element(&entries_[begin], &entries_[mid * kBucket], entries_.data() + end,
                     [axis](const Entry& a, const Entry& b) {
                       return a.at[axis] != b.at[axis] ? a.at[axis] < b.at[axis]
                                                       : a.index < b.index;
                     });
  }
  build(2 * node, first, mid);
  build(2 * node + 1, mid, last);
}

/// Buckets of `node` nearer to the box than the reach go on the list of near ones.
void PointNeighbours::gather(std::uint32_t node, std::uint32_t first, std::uint32_t last,
                             const Box& around, float sq_reach) noexcept {
  const Box& box = boxes_[node];
  const Float4 gap =
      max4(max4(load4(box.low) - load4(around.high), load4(around.low) - load4(box.high)), all4(0));
  const Float4 square = gap * gap;
  if (square[0] + square[1] + square[2] > sq_reach) return;
  if (last - first > 1) {
    const std::uint32_t mid = middle(first, last);
    gather(2 * node, first, mid, around, sq_reach);
    gather(2 * node + 1, mid, last, around, sq_reach);
    return;
  }
  near_[near_count_] = first;
  for (int a = 0; a < 3; ++a) {
    near_box_[a][near_count_] = box.low[a];
    near_box_[3 + a][near_count_] = box.high[a];
  }
  ++near_count_;
}

/// The points looked for around one point, as they are found.
class PointNeighbours::Query {
 public:
  Query(const PointNeighbours& cloud, std::uint32_t place, float sq_reach) noexcept
      : cloud_(&cloud),
        place_(place),
        x_(all4(cloud.x_[place])),
        y_(all4(cloud.y_[place])),
        z_(all4(cloud.z_[place])),
        sq_reach_(sq_reach) {}

  /// Takes the points of a bucket that are within reach.
  void scan(std::uint32_t bucket) noexcept {
    if (count_ > kMostHits - kBucket) keep_nearest();
    const std::uint32_t first = bucket * kBucket;
    const Float4 limit = all4(sq_reach_);
    for (std::uint32_t n = first; n < first + kBucket; n += 4) {
      const Float4 dx = load4(&cloud_->x_[n]) - x_;
      const Float4 dy = load4(&cloud_->y_[n]) - y_;
      const Float4 dz = load4(&cloud_->z_[n]) - z_;
      const Float4 sq = dx * dx + dy * dy + dz * dz;
      unsigned bits = lane_bits(sq <= limit);
      if (place_ - n < 4) bits &= ~(1U << (place_ - n));  // itself
      if (bits == 0) continue;
      float lanes[4];
      store4(lanes, sq);
      for (unsigned lane = 0; lane < 4; ++lane) {
        sq_[count_] = lanes[lane];
        id_[count_] = n + lane;
        count_ += (bits >> lane) & 1U;
      }
    }
  }

  /// Scans the near buckets but `own`, which was scanned.
  void scan_near(std::uint32_t own) noexcept {
    for (std::uint32_t c = 0; c < cloud_->near_count_; c += 4) {
      const auto gap = [&](int a, Float4 at) {
        return max4(
            max4(load4(&cloud_->near_box_[a][c]) - at, at - load4(&cloud_->near_box_[3 + a][c])),
            all4(0));
      };
      const Float4 gx = gap(0, x_), gy = gap(1, y_), gz = gap(2, z_);
      const Float4 sq = gx * gx + gy * gy + gz * gz;
      for (unsigned bits = lane_bits(sq <= all4(sq_reach_)); bits != 0; bits &= bits - 1) {
        const auto lane = static_cast<std::uint32_t>(std::countr_zero(bits));
        if (c + lane >= cloud_->near_count_) break;
        const std::uint32_t bucket = cloud_->near_[c + lane];
        // Once reach is the k-th distance itself, equally far points change nothing.
        if (bucket != own && (sq[lane] < sq_reach_ || !tight_)) scan(bucket);
      }
    }
  }

  std::uint32_t count() const noexcept { return count_; }

  /// Leaves the k nearest of those found, k <= count(); returns the greatest squared distance.
  float keep_nearest() noexcept {
    const std::uint32_t k = cloud_->k_;
    if (count_ > k) select(k);
    float most = 0;
    for (std::uint32_t i = 0; i < count_; ++i) most = std::max(most, sq_[i]);
    if (count_ == k) {
      sq_reach_ = most;
      tight_ = true;
    }
    return most;
  }

  const std::uint32_t* ids() const noexcept { return id_; }
  float mean_distance() const noexcept {
    float sum = 0;
    for (std::uint32_t i = 0; i < count_; ++i) sum += std::sqrt(sq_[i]);
    return sum / static_cast<float>(count_);
  }

 private:
  static constexpr std::uint32_t kMostHits = 3 * kMaxNeighbours + kBucket;

  std::uint32_t count_up_to(float limit) const noexcept {
    Int4 sum = {0, 0, 0, 0};
    const Float4 most = all4(limit);
    for (std::uint32_t i = 0; i < count_; i += 4) sum -= load4(&sq_[i]) <= most;
    return static_cast<std::uint32_t>(sum[0] + sum[1] + sum[2] + sum[3]);
  }

  /// Finds a distance that k points do not exceed, by trying: on a surface their number grows with
  /// its square. Ties at the limit are cut in the order of scanning.
  void select(std::uint32_t k) noexcept {
    for (std::uint32_t i = count_; i < ((count_ + 3) & ~3U); ++i) sq_[i] = kInfinity;
    float low = -1, high = sq_reach_;  // fewer than k are within low, k or more within high
    std::uint32_t below = 0, within = count_;
    for (int round = 0; within != k && round < 24; ++round) {
      const float from = std::max(low, 0.0F);
      float share = (static_cast<float>(k - below) - 0.5F) / static_cast<float>(within - below);
      if ((round & 3) == 3) share = 0.5F;
      const float limit = from + (high - from) * share;
      if (!(limit > low) || !(limit < high)) break;
      const std::uint32_t n = count_up_to(limit);
      if (n < k) {
        low = limit;
        below = n;
      } else {
        high = limit;
        within = n;
      }
    }
    if (within != k) high = exact_limit(k);
    std::uint32_t ties = within == k ? k : 0;  // how many at the limit itself there is room for
    if (within != k) {
      std::uint32_t nearer = 0;
      for (std::uint32_t i = 0; i < count_; ++i) nearer += sq_[i] < high ? 1 : 0;
      ties = k - nearer;
    }
    std::uint32_t kept = 0;
    for (std::uint32_t i = 0; i < count_; ++i) {
      const float sq = sq_[i];
      const bool at_limit = sq == high;
      if (sq > high || (at_limit && ties == 0)) continue;
      ties -= at_limit ? 1 : 0;
      sq_[kept] = sq;
      id_[kept++] = id_[i];
    }
    count_ = kept;
  }

  float exact_limit(std::uint32_t k) noexcept {
    float copy[kMostHits];
    std::copy_n(sq_, count_, copy);
    std::nth_element(copy, copy + k - 1, copy + count_);
    return copy[k - 1];
  }

  const PointNeighbours* cloud_;
  std::uint32_t place_;
  Float4 x_, y_, z_;
  float sq_reach_;
  bool tight_ = false;  ///< sq_reach_ is the k-th least distance found
  std::uint32_t count_ = 0;
  alignas(16) float sq_[kMostHits + 4];
  std::uint32_t id_[kMostHits + 4];
};

/// The smallest node round the bucket with more than k points: its diagonal is a distance that at
/// least k others of any of its points cannot exceed.
PointNeighbours::Crowd PointNeighbours::crowd_of(std::uint32_t bucket) const noexcept {
  Crowd crowd{1, 0, buckets_, 0};
  for (Crowd node = crowd;;) {
    if (std::min(node.last * kBucket, size_) - node.first * kBucket <= k_) break;
    crowd = node;
    if (node.last - node.first < 2) break;
    const std::uint32_t mid = middle(node.first, node.last);
    const bool left = bucket < mid;
    node.node = 2 * node.node + (left ? 0 : 1);
    (left ? node.last : node.first) = mid;
  }
  const Box& box = boxes_[crowd.node];
  float sq = 0;
  for (int a = 0; a < 3; ++a) sq += (box.high[a] - box.low[a]) * (box.high[a] - box.low[a]);
  crowd.reach = std::sqrt(sq);
  return crowd;
}

void PointNeighbours::search_bucket(std::uint32_t bucket) noexcept {
  const std::uint32_t begin = bucket * kBucket, end = std::min(begin + kBucket, size_);
  const auto distance = [&](std::uint32_t a, std::uint32_t b) {
    const float dx = x_[a] - x_[b], dy = y_[a] - y_[b], dz = z_[a] - z_[b];
    return std::sqrt(dx * dx + dy * dy + dz * dz);
  };
  const Crowd crowd = crowd_of(bucket);
  float first_reach = 0;  // of the bucket's first point, once it is known
  for (std::uint32_t n = begin; n < end; ++n) {
    // No k-th neighbour is farther than another point's k-th and the way to that point.
    float reach = std::min(crowd.reach, last_reach_ + distance(last_query_, n));
    if (n == begin) {
      collect(crowd, n, n + 1, reach);
    } else {
      reach = std::min(reach, first_reach + distance(begin, n));
      if (n == begin + 1) {
        float way = 0;
        for (std::uint32_t m = n; m < end; ++m) way = std::max(way, distance(begin, m));
        collect(crowd, begin, end, std::min(crowd.reach, first_reach + way));
      }
    }
    last_reach_ = search_point(bucket, n, reach);
    last_query_ = n;
    if (n == begin) first_reach = last_reach_;
  }
}

/// Lists the buckets within reach of the box round the points [begin, end). A pile of equal points
/// needs no others, and may have any number of them.
void PointNeighbours::collect(const Crowd& crowd, std::uint32_t begin, std::uint32_t end,
                              float reach) noexcept {
  Box around = {};
  for (int a = 0; a < 3; ++a) {
    const float* c = (a == 0 ? x_ : (a == 1 ? y_ : z_)).data();
    around.low[a] = *std::min_element(c + begin, c + end);
    around.high[a] = *std::max_element(c + begin, c + end);
  }
  near_count_ = 0;
  const float wide = reach * kMargin;
  const bool pile = crowd.reach == 0;
  const Crowd all{1, 0, buckets_, 0};
  const Crowd& from = pile && reach == 0 ? crowd : all;
  gather(from.node, from.first, from.last, around, wide * wide);
}

/// Stores the neighbours of the point `n` of `bucket`, none of them farther than `reach`; returns
/// how far the farthest is.
float PointNeighbours::search_point(std::uint32_t bucket, std::uint32_t n, float reach) noexcept {
  const float wide = reach * kMargin;
  Query query(*this, n, wide * wide);
  query.scan(bucket);
  query.scan_near(bucket);
  if (query.count() < k_) {  // squares below the least float: then all of the cloud is near
    collect({1, 0, buckets_, 0}, n, n + 1, kInfinity);
    query = Query(*this, n, std::numeric_limits<float>::max());
    query.scan(bucket);
    query.scan_near(bucket);
  }
  const float sq = query.keep_nearest();
  std::copy_n(query.ids(), k_, &ids_[std::size_t{n} * k_]);
  mean_distance_[n] = query.mean_distance();
  return std::sqrt(sq);
}

}  // namespace planecast
