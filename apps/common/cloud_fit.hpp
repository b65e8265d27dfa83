// How well a cloud's points lie on a stream's camera and depth grid: measured once to decide how a
// stream is coded, and checked for every later frame, so that no bound is broken before the codec.
#pragma once

#include <cmath>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/base/status.hpp"
#include "core/cloud/sensor_frame.hpp"
#include "core/model/stream_config.hpp"
#include "core/sensor/ray_table.hpp"

namespace planecast {

/// True when the point is a reading: finite, and not the exact origin that some recorders write for
/// a hole.
inline bool is_depth_reading(const Point3f& p) noexcept {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z) &&
         (p.x != 0 || p.y != 0 || p.z != 0);
}

/// From a cloud's own axes to the optical ones of its camera, and back.
class OpticalAxes {
 public:
  explicit OpticalAxes(const StreamConfig& config);

  /// Depth along the optical axis [m].
  double depth(const Point3f& p) const noexcept {
    if (identity_) return p.z;
    return m_[0][2] * (p.x - t_[0]) + m_[1][2] * (p.y - t_[1]) + m_[2][2] * (p.z - t_[2]);
  }
  /// The point at `depth` on the ray (x, y, 1), in the cloud's axes [m], as the decoder has it.
  Point3f point(double x, double y, double depth) const noexcept {
    const double px = x * depth, py = flip_y_ * y * depth;
    if (identity_)
      return {static_cast<float>(px), static_cast<float>(py), static_cast<float>(depth)};
    return {static_cast<float>(m_[0][0] * px + m_[0][1] * py + m_[0][2] * depth + t_[0]),
            static_cast<float>(m_[1][0] * px + m_[1][1] * py + m_[1][2] * depth + t_[1]),
            static_cast<float>(m_[2][0] * px + m_[2][1] * py + m_[2][2] * depth + t_[2])};
  }

 private:
  bool identity_;
  double m_[3][3];
  double t_[3];
  double flip_y_;
};

/// A camera's rays with their storage.
struct CameraRays {
  std::vector<std::int32_t> storage;
  RayTable table;
};

/// Builds the rays of a camera; kBadConfig when its distortion cannot be undone.
Result<std::shared_ptr<const CameraRays>> camera_rays(const CameraModel& camera);

/// The error contract as asked for, before anything is taken off for a cloud's own misfit.
struct Contract {
  ToleranceKind kind = ToleranceKind::kLossless;
  double value = 0;  ///< kMetres [m]; kSigma, kSurfaces: multiples of sigma
  NoiseModel noise;

  /// The bound of a reading at a depth [m]; 0 when lossless.
  double bound_m(double depth_m) const noexcept {
    switch (kind) {
      case ToleranceKind::kMetres:
        return value;
      case ToleranceKind::kSigma:
      case ToleranceKind::kSurfaces:
        return value * noise.sigma_m(depth_m);
      case ToleranceKind::kLossless:
        break;
    }
    return 0;
  }
};

/// How far points are from where their pixel's ray and their count put them.
struct CloudFit {
  double worst_m = 0;        ///< largest distance, rounding to the grid included [m]
  double worst_share = 0;    ///< largest distance over that point's bound; infinite for bound 0
  double lateral_share = 0;  ///< the same for the distance from the ray alone
};

/// A pixel's column and row.
struct PixelAt {
  std::uint32_t u = 0, v = 0;
};

/// Squared distance of a pixel's point from the one that lies on its ray at `depth` [m^2].
inline double misfit_square_m2(const OpticalAxes& axes, const RayTable& rays, const Point3f& point,
                               PixelAt at, double depth) noexcept {
  constexpr double kRayUnit = 1.0 / 134217728.0;  // 2^-27
  const Point3f made =
      axes.point(rays.x(at.u, at.v) * kRayUnit, rays.y(at.u, at.v) * kRayUnit, depth);
  const double x = double{point.x} - made.x, y = double{point.y} - made.y;
  const double z = double{point.z} - made.z;
  return x * x + y * y + z * z;
}

/// Measures all readings with counts between the limits. `depth` holds the cloud's counts. O(n).
CloudFit measure_fit(const StreamConfig& config, const RayTable& rays, const Contract& contract,
                     std::span<const Point3f> points, std::span<const std::uint16_t> depth,
                     std::uint16_t least, std::uint16_t most) noexcept;

}  // namespace planecast
