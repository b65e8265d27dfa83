#include "bench/baselines/delaunay.hpp"

#include <algorithm>
#include <map>
#include <numeric>

namespace planecast::baselines {
namespace {

constexpr std::int64_t kFrame = std::int64_t{1} << 26;

__extension__ typedef __int128 Wide;

// Over 0: a, b, c turn left. Coordinates to 2^27: products to 2^56.
std::int64_t turn(const Point2i& a, const Point2i& b, const Point2i& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

// Orders points so that neighbours in the list are near each other: short walks.
std::uint64_t place(const Point2i& p) {
  std::uint64_t code = 0;
  const auto x = static_cast<std::uint64_t>(p.x + kMostCoordinate);
  const auto y = static_cast<std::uint64_t>(p.y + kMostCoordinate);
  for (int bit = 21; bit >= 0; --bit) code = code << 2 | (x >> bit & 1) << 1 | (y >> bit & 1);
  return code;
}

}  // namespace

Delaunay::Delaunay(const std::vector<Point2i>& points) : points_(points) {
  const auto count = static_cast<std::uint32_t>(points.size());
  points_.push_back({-kFrame, -kFrame});
  points_.push_back({2 * kFrame, -kFrame});
  points_.push_back({-kFrame, 2 * kFrame});
  faces_.push_back({{count, count + 1, count + 2}, {-1, -1, -1}, true});
  std::vector<std::uint32_t> order(count);
  std::iota(order.begin(), order.end(), 0u);
  std::vector<std::uint64_t> key(count);
  std::transform(points.begin(), points.end(), key.begin(), place);
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return key[a] < key[b]; });
  for (const std::uint32_t vertex : order) insert(vertex);
  number_.assign(faces_.size(), -1);
  for (std::size_t f = 0; f < faces_.size(); ++f) {
    const auto& corner = faces_[f].corner;
    if (!faces_[f].alive ||
        std::any_of(corner.begin(), corner.end(), [count](std::uint32_t c) { return c >= count; }))
      continue;
    number_[f] = static_cast<int>(triangles_.size());
    triangles_.push_back(corner);
  }
}

// Goes through the side that has `p` behind it until there is none.
int Delaunay::walk(const Point2i& p) {
  int face = last_;
  for (;;) {
    int through = -1;
    for (int i = 0; i < 3 && through < 0; ++i) {
      const auto& f = faces_[face];
      if (turn(points_[f.corner[(i + 1) % 3]], points_[f.corner[(i + 2) % 3]], p) < 0)
        through = f.next[i];
    }
    if (through < 0) return last_ = face;
    face = through;
  }
}

bool Delaunay::in_circle(const Face& face, const Point2i& p) const {
  Wide d[3][3];
  for (int i = 0; i < 3; ++i) {
    const Point2i& c = points_[face.corner[i]];
    d[i][0] = c.x - p.x;
    d[i][1] = c.y - p.y;
    d[i][2] = d[i][0] * d[i][0] + d[i][1] * d[i][1];
  }
  return d[0][0] * (d[1][1] * d[2][2] - d[1][2] * d[2][1]) -
             d[0][1] * (d[1][0] * d[2][2] - d[1][2] * d[2][0]) +
             d[0][2] * (d[1][0] * d[2][1] - d[1][1] * d[2][0]) >
         0;
}

void Delaunay::insert(std::uint32_t vertex) {
  const Point2i& p = points_[vertex];
  const int home = walk(p);
  for (const std::uint32_t c : faces_[home].corner) {
    if (points_[c].x == p.x && points_[c].y == p.y) return;
  }
  // The hole: every face whose circle holds the point, from its home outwards. A face whose side
  // the point lies on is one of them.
  std::vector<int> hole{home};
  faces_[home].alive = false;
  struct Side {
    std::uint32_t a, b;
    int outer;
  };
  std::vector<Side> rim;
  for (std::size_t next = 0; next < hole.size(); ++next) {
    for (int i = 0; i < 3; ++i) {
      const Face face = faces_[hole[next]];
      const std::uint32_t a = face.corner[(i + 1) % 3], b = face.corner[(i + 2) % 3];
      const int outer = face.next[i];
      if (outer >= 0 && !faces_[outer].alive) continue;
      if (outer >= 0 && (in_circle(faces_[outer], p) || turn(points_[a], points_[b], p) == 0)) {
        faces_[outer].alive = false;
        hole.push_back(outer);
      } else {
        rim.push_back({a, b, outer});
      }
    }
  }
  // A side between two faces of the hole is not of its rim, though one was met before the other.
  std::erase_if(rim, [&](const Side& s) { return s.outer >= 0 && !faces_[s.outer].alive; });
  std::map<std::uint32_t, int> begins, ends;
  for (const Side& side : rim) {
    const int face = static_cast<int>(faces_.size());
    faces_.push_back({{vertex, side.a, side.b}, {side.outer, -1, -1}, true});
    begins[side.a] = face;
    ends[side.b] = face;
    if (side.outer < 0) continue;
    Face& outer = faces_[side.outer];
    for (int i = 0; i < 3; ++i) {
      if (outer.corner[i] != side.a && outer.corner[i] != side.b) outer.next[i] = face;
    }
  }
  for (const auto& [a, face] : begins) {
    faces_[face].next[1] = begins.at(faces_[face].corner[2]);  // behind side (b, vertex)
    faces_[face].next[2] = ends.at(a);                         // behind side (vertex, a)
  }
  last_ = static_cast<int>(faces_.size()) - 1;
}

int Delaunay::find(const Point2i& p) {
  if (triangles_.empty()) return -1;
  int real = -1, face = last_;
  for (;;) {
    if (number_[face] >= 0) real = number_[face];
    int through = -1;
    for (int i = 0; i < 3 && through < 0; ++i) {
      const auto& f = faces_[face];
      if (turn(points_[f.corner[(i + 1) % 3]], points_[f.corner[(i + 2) % 3]], p) < 0)
        through = f.next[i];
    }
    if (through < 0) break;
    face = through;
  }
  if (number_[face] >= 0) last_ = face;
  return real >= 0 ? real : 0;
}

}  // namespace planecast::baselines
