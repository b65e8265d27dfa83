// Finds the camera of an organised cloud that came without one: from where the points lie and which
// pixel holds them, the focal lengths, the centre, and how the cloud was turned away from the
// camera. Encoder half, cold path.
#pragma once

#include <cstdint>
#include <string>

#include "core/base/status.hpp"
#include "core/cloud/sensor_frame.hpp"
#include "core/sensor/camera.hpp"

namespace planecast {

/// A camera fitted to a cloud: point(u, v) ~ T * M * z * ((u - cx) / fx, (v - cy) / fy, 1), where
/// T = cloud_from_optical and M mirrors y when mirror_y. Residuals compare each point with the one
/// its pixel's ray has at the point's own optical z.
struct EstimatedCamera {
  enum class Model : std::uint8_t {
    kPinhole = 0,  ///< the cloud is in optical axes: pose is the identity
    kRotated = 1,  ///< turned about the optical centre
    kMoved = 2,    ///< turned and shifted
  };

  Intrinsics intrinsics;  ///< no distortion; metres_per_unit as it was, 0.001
  Pose cloud_from_optical;
  bool mirror_y = false;  ///< the cloud's axes are left-handed; y is flipped before the pose
  Model model = Model::kPinhole;
  std::uint64_t points = 0;                       ///< valid points used
  double max_residual_m = 0, rms_residual_m = 0;  ///< over all valid points
  double max_residual_px = 0, rms_residual_px = 0;
  std::uint64_t inliers = 0;  ///< points that agree with the fit: within 5 medians or 5 um
  double inlier_max_residual_m = 0;

  /// One sentence for people: model, intrinsics and residuals.
  std::string describe() const;
};

/// Fits the simplest of the three models that explains an organised cloud (row-major, NaN = hole).
/// A large residual is not an error: the caller compares it with its bound. It means a distorted
/// lens, a LiDAR, a resampled cloud, or single pixels whose points are not on their rays (inliers <
/// points; the fit itself ignores up to about a third of such). O(points), 0.02 to 0.3 s for 640 x
/// 480; allocates. Errors: kBadConfig: not organised, or too few or too special points to tell
/// (fewer than 16, all in one row or column); the message says to give the camera.
Result<EstimatedCamera> estimate_camera(const PointCloud& cloud);

}  // namespace planecast
