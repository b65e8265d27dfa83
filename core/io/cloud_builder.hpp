// From the coordinates of a file (double) to the PointCloud of the codec (float): shape, invalid
// points and the large offsets of mapped data (UTM) are settled here, once for every format.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/base/status.hpp"
#include "core/cloud/sensor_frame.hpp"

namespace planecast {

/// A point as a file states it [the file's unit]; not finite means "no reading".
struct Point3d {
  double x = 0;
  double y = 0;
  double z = 0;
};

/// What the file stores: float32 is taken bit for bit; wide (double, text) may need an origin.
enum class CoordinateKind : std::uint8_t { kFloat32, kWide };

/// Wide coordinates beyond this magnitude would lose more than 4 mm in a float.
inline constexpr double kOriginThreshold = 1e5;

/// Makes a cloud of `width` x `height` points (row-major, points.size() == width * height).
/// Infinite coordinates become NaN. A wide axis with a value beyond kOriginThreshold has its median
/// (rounded to a whole unit, so that it prints short) subtracted and kept in origin_*.
/// One column (1 x N) is a list written sideways and becomes N x 1.
/// Errors: kUnreadable when a coordinate fits no float even so. Cost O(n), one copy.
Result<PointCloud> build_cloud(const std::filesystem::path& path, std::uint32_t width,
                               std::uint32_t height, const std::vector<Point3d>& points,
                               CoordinateKind kind, std::vector<std::string> dropped_fields);

/// The point in the file's coordinates again: origin added in double.
inline Point3d absolute_point(const PointCloud& cloud, const Point3f& p) noexcept {
  return {p.x + cloud.origin_x, p.y + cloud.origin_y, p.z + cloud.origin_z};
}

/// True when absolute coordinates need more than float32.
inline bool has_origin(const PointCloud& cloud) noexcept {
  return cloud.origin_x != 0 || cloud.origin_y != 0 || cloud.origin_z != 0;
}

/// True when the point is a reading: no coordinate is NaN or infinite.
bool is_valid(const Point3f& point) noexcept;

}  // namespace planecast
