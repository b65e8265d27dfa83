#include "core/io/cloud_builder.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/io/io_error.hpp"

namespace planecast {
namespace {

// The median, not the mean: one wild point must not push all others out of float's fine range.
double origin_of_axis(const std::vector<Point3d>& points, double Point3d::*axis) {
  const auto needs_origin = [axis](const Point3d& p) {
    return std::isfinite(p.*axis) && std::abs(p.*axis) > kOriginThreshold;
  };
  if (std::none_of(points.begin(), points.end(), needs_origin)) return 0;
  std::vector<double> values;
  values.reserve(points.size());
  for (const Point3d& p : points) {
    if (std::isfinite(p.*axis)) values.push_back(p.*axis);
  }
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return std::nearbyint(*middle);
}

std::optional<float> to_float(double value, double origin) noexcept {
  if (!std::isfinite(value)) return std::numeric_limits<float>::quiet_NaN();
  const double local = value - origin;
  if (std::abs(local) > static_cast<double>(std::numeric_limits<float>::max())) return std::nullopt;
  return static_cast<float>(local);
}

void set_shape(PointCloud& cloud, std::uint32_t width, std::uint32_t height) noexcept {
  const bool one_column = width == 1 && height > 1;
  cloud.width = one_column ? height : width;
  cloud.height = one_column || width == 0 || height == 0 ? 1 : height;
  if (height == 0) cloud.width = 0;
}

}  // namespace

bool is_valid(const Point3f& point) noexcept {
  return std::isfinite(point.x) && std::isfinite(point.y) && std::isfinite(point.z);
}

Result<PointCloud> build_cloud(const std::filesystem::path& path, std::uint32_t width,
                               std::uint32_t height, const std::vector<Point3d>& points,
                               CoordinateKind kind, std::vector<std::string> dropped_fields) {
  PointCloud cloud;
  set_shape(cloud, width, height);
  cloud.dropped_fields = std::move(dropped_fields);
  if (kind == CoordinateKind::kWide) {
    cloud.origin_x = origin_of_axis(points, &Point3d::x);
    cloud.origin_y = origin_of_axis(points, &Point3d::y);
    cloud.origin_z = origin_of_axis(points, &Point3d::z);
  }
  cloud.points.reserve(points.size());
  for (const Point3d& p : points) {
    const auto x = to_float(p.x, cloud.origin_x);
    const auto y = to_float(p.y, cloud.origin_y);
    const auto z = to_float(p.z, cloud.origin_z);
    if (!x || !y || !z) {
      return file_error(path, "point " + std::to_string(cloud.points.size()),
                        "a coordinate is beyond the range of float32",
                        "remove the point, or give the coordinates in metres");
    }
    cloud.points.push_back({*x, *y, *z});
  }
  return cloud;
}

}  // namespace planecast
