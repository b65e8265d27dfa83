#include "core/regen/point_regen.hpp"

namespace planecast {

Status regenerate_points(const PointStream& stream, std::span<const GridPoint> points,
                         std::span<Point3f> out) noexcept {
  if (points.size() != out.size()) return Status::kWrongSize;
  const double step_m = grid_step_m(stream);
  bool finite = true;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Point3f p = grid_metres(points[i], step_m);
    finite = finite && p.x - p.x == 0 && p.y - p.y == 0 && p.z - p.z == 0;
    out[i] = p;
  }
  return finite ? Status::kOk : Status::kBadSymbol;
}

}  // namespace planecast
