// One frame as a source gives it, before any codec sees it: a depth image or a list of points.
// Owning and growable: cold path only. The pipeline copies it into a slot of fixed memory.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace planecast {

/// Largest side of an image or an organised cloud [px].
inline constexpr std::uint32_t kMaxImageSide = 16384;

/// A point in metres, in the frame its container names; NaN in any coordinate means "no reading".
struct Point3f {
  float x = 0;
  float y = 0;
  float z = 0;
};

/// Rigid pose of the sensor in the world: unit quaternion (w, x, y, z) and translation in metres.
struct Pose {
  double qw = 1, qx = 0, qy = 0, qz = 0;
  double tx = 0, ty = 0, tz = 0;
};

/// A list of points, organised when height > 1 (row-major, points.size() == width * height).
/// Invalid points of an organised cloud are NaN.
struct PointCloud {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::vector<Point3f> points;  ///< [m]; relative to origin_* when those are not zero
  double origin_x = 0, origin_y = 0,
         origin_z = 0;                      ///< subtracted in double before the cut to float (UTM)
  std::vector<std::string> dropped_fields;  ///< fields the file has and this codec does not carry
  Pose viewpoint;  ///< sensor in the world (PCD VIEWPOINT); identity when the file states none
  bool organised() const noexcept { return height > 1; }
};

/// A depth image in the sensor's own units: row-major, width * height values, 0 = no reading.
struct DepthImage {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::vector<std::uint16_t> depth;
};

/// What a source delivers: exactly one of depth (width > 0) or cloud (width > 0) is set.
struct SensorFrame {
  DepthImage depth;
  PointCloud cloud;
  std::string name;           ///< file name or "sim:room#12", for messages
  std::uint64_t number = 0;   ///< counts from 0 in the source's order
  std::int64_t stamp_ns = 0;  ///< time of capture; clock named by the source
  Pose pose;
  std::string frame_id;  ///< coordinate frame, e.g. "camera_optical"
};

}  // namespace planecast
