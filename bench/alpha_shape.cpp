#include "bench/alpha_shape.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "bench/baselines/delaunay.hpp"

namespace planecast::bench {
namespace {

using baselines::Point2i;

// Two axes across the normal.
struct Axes {
  double u[3], v[3];

  explicit Axes(const double (&n)[3]) {
    const int most = std::abs(n[0]) > std::abs(n[1]) ? 0 : 1;
    const double length = std::hypot(n[most], n[2]);
    u[most] = n[2] / length;
    u[1 - most] = 0;
    u[2] = -n[most] / length;
    v[0] = n[1] * u[2] - n[2] * u[1];
    v[1] = n[2] * u[0] - n[0] * u[2];
    v[2] = n[0] * u[1] - n[1] * u[0];
  }
};

double twice_area(const Point2i& a, const Point2i& b, const Point2i& c) {
  return static_cast<double>((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x));
}

double length(const Point2i& a, const Point2i& b) {
  return std::hypot(static_cast<double>(b.x - a.x), static_cast<double>(b.y - a.y));
}

}  // namespace

AlphaShape alpha_shape(const baselines::PointList& points, const double (&n)[3], double alpha_m) {
  const Axes axes(n);
  std::vector<std::pair<double, double>> flat;
  double low[2] = {1e300, 1e300}, high[2] = {-1e300, -1e300};
  for (const Point3f& p : points) {
    const double a = axes.u[0] * p.x + axes.u[1] * p.y + axes.u[2] * p.z;
    const double b = axes.v[0] * p.x + axes.v[1] * p.y + axes.v[2] * p.z;
    flat.emplace_back(a, b);
    low[0] = std::min(low[0], a), high[0] = std::max(high[0], a);
    low[1] = std::min(low[1], b), high[1] = std::max(high[1], b);
  }
  const double extent = std::max({high[0] - low[0], high[1] - low[1], 1e-6});
  const double unit = extent / (2.0 * (baselines::kMostCoordinate - 1));
  std::vector<Point2i> places;
  for (const auto& [a, b] : flat) {
    places.push_back({std::llround((a - (low[0] + high[0]) / 2) / unit),
                      std::llround((b - (low[1] + high[1]) / 2) / unit)});
  }
  AlphaShape shape;
  std::set<std::pair<std::uint32_t, std::uint32_t>> border;  // sides seen from one triangle so far
  const baselines::Delaunay mesh(places);
  for (const auto& t : mesh.triangles()) {
    const Point2i &a = places[t[0]], &b = places[t[1]], &c = places[t[2]];
    const double twice = twice_area(a, b, c);
    if (length(a, b) * length(b, c) * length(c, a) / (2 * twice) * unit > alpha_m) continue;
    shape.area_m2 += twice / 2 * unit * unit;
    for (int i = 0; i < 3; ++i) {
      const std::uint32_t from = t[i], to = t[(i + 1) % 3];
      if (border.erase({to, from}) == 0) border.insert({from, to});
    }
  }
  shape.corners = border.size();  // an outline has as many corners as sides
  return shape;
}

}  // namespace planecast::bench
