#include "apps/common/near_grid.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>

namespace planecast {

void NearGrid::reserve(std::size_t most) {
  entries_.resize(most);
}

// Three numbers of cells hashed into one. Different cells that share a hash only make more points
// to look at: each is measured.
std::uint64_t NearGrid::cell_of(double x, double y, double z) const noexcept {
  const auto number = [](double v) {
    return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::clamp(v, -9e18, 9e18)));
  };
  std::uint64_t hash = number(x) * 0x9E3779B97F4A7C15ULL;
  hash = (hash ^ (hash >> 29U)) + number(y) * 0xBF58476D1CE4E5B9ULL;
  hash = (hash ^ (hash >> 32U)) + number(z) * 0x94D049BB133111EBULL;
  return hash;
}

bool NearGrid::fill(std::span<const Point3f> points, double distance_m) noexcept {
  used_ = 0;
  if (points.size() > entries_.size()) return false;
  points_ = points;
  distance_m_ = distance_m;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    const Point3f& p = points[i];
    entries_[used_++] = {cell_of(std::floor(p.x / distance_m), std::floor(p.y / distance_m),
                                 std::floor(p.z / distance_m)),
                         i};
  }
  std::sort(entries_.begin(), entries_.begin() + static_cast<std::ptrdiff_t>(used_),
            [points](const Entry& a, const Entry& b) {
              const Point3f &p = points[a.point], &q = points[b.point];
              return std::tie(a.cell, p.x, p.y, p.z) < std::tie(b.cell, q.x, q.y, q.z);
            });
  const auto end =
      std::unique(entries_.begin(), entries_.begin() + static_cast<std::ptrdiff_t>(used_),
                  [points](const Entry& a, const Entry& b) {
                    const Point3f &p = points[a.point], &q = points[b.point];
                    return p.x == q.x && p.y == q.y && p.z == q.z;
                  });
  used_ = static_cast<std::size_t>(end - entries_.begin());
  return true;
}

double NearGrid::farthest_m(const NearGrid& other) const noexcept {
  double worst = 0;
  for (std::size_t i = 0; i < used_; ++i)
    worst = std::max(worst, other.nearest_m(points_[entries_[i].point], worst));
  return worst;
}

double NearGrid::nearest_m(const Point3f& p, double enough_m) const noexcept {
  // The point's own cell first: most look-ups end there.
  constexpr std::array<int, 3> kSteps{0, -1, 1};
  const double limit = distance_m_ * distance_m_;
  double best = std::numeric_limits<double>::infinity();
  const double x = std::floor(p.x / distance_m_), y = std::floor(p.y / distance_m_),
               z = std::floor(p.z / distance_m_);
  const auto end = entries_.begin() + static_cast<std::ptrdiff_t>(used_);
  for (std::size_t i = 0; i < 27 && best > enough_m * enough_m; ++i) {
    const std::uint64_t cell = cell_of(x + kSteps[i % 3], y + kSteps[i / 3 % 3], z + kSteps[i / 9]);
    auto at = std::lower_bound(entries_.begin(), end, cell,
                               [](const Entry& e, std::uint64_t c) { return e.cell < c; });
    for (; at != end && at->cell == cell; ++at) {
      const Point3f& q = points_[at->point];
      const double dx = double{p.x} - q.x, dy = double{p.y} - q.y, dz = double{p.z} - q.z;
      best = std::min(best, dx * dx + dy * dy + dz * dz);
    }
  }
  return best <= limit ? std::sqrt(best) : std::numeric_limits<double>::infinity();
}

}  // namespace planecast
