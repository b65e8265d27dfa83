// How well a cloud's points lie on a stream's camera and depth grid: measured once to decide how a
// stream is coded, and checked for every later frame, so that no bound is broken before the codec.
#pragma once

#include <cmath>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/base/lanes.hpp"
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
  /// Coordinates [m] of one point, or of a vector of points.
  template <class Real>
  struct Point {
    Real x, y, z;
  };

  explicit OpticalAxes(const StreamConfig& config);

  /// Depth of a point along the optical axis [m]; of one, or of a vector of points.
  template <class Real>
  Real depth(Real x, Real y, Real z) const noexcept {
    if (identity_) return z;
    return m_[0][2] * (x - t_[0]) + m_[1][2] * (y - t_[1]) + m_[2][2] * (z - t_[2]);
  }
  double depth(const Point3f& p) const noexcept { return depth<double>(p.x, p.y, p.z); }
  /// The point at `depth` on the ray (x, y, 1), in the cloud's axes [m], as the decoder has it.
  template <class Real>
  Point<Real> point(Real x, Real y, Real depth) const noexcept {
    const Real px = x * depth, py = flip_y_ * y * depth;
    if (identity_) return {as_float(px), as_float(py), as_float(depth)};
    return {as_float(m_[0][0] * px + m_[0][1] * py + m_[0][2] * depth + t_[0]),
            as_float(m_[1][0] * px + m_[1][1] * py + m_[1][2] * depth + t_[1]),
            as_float(m_[2][0] * px + m_[2][1] * py + m_[2][2] * depth + t_[2])};
  }

 private:
  static double as_float(double value) noexcept { return static_cast<float>(value); }
  static Double2 as_float(Double2 value) noexcept { return as_float2(value); }

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

/// A bound as a polynomial of the depth: of one length, or one that grows as sigma does.
struct BoundCurve {
  double length_m = 0;
  double per_square = 0;  ///< added for each square metre of depth [1/m]

  /// At the depth of one reading, or of a vector of them [m].
  template <class Real>
  Real at(Real depth_m) const noexcept {
    return length_m + per_square * depth_m * depth_m;
  }
  /// The curve of that share of each bound.
  BoundCurve times(double share) const noexcept { return {length_m * share, per_square * share}; }
};

/// The error contract as asked for, before anything is taken off for a cloud's own misfit.
struct Contract {
  ToleranceKind kind = ToleranceKind::kLossless;
  double value = 0;  ///< kMetres [m]; kSigma, kSurfaces: multiples of sigma
  NoiseModel noise;

  /// The bound of a reading [m] over its depth [m]; 0 when lossless.
  BoundCurve bound_curve() const noexcept {
    switch (kind) {
      case ToleranceKind::kMetres:
        return {value, 0};
      case ToleranceKind::kSigma:
      case ToleranceKind::kSurfaces:
        // A sigma is one length, or grows as the square of the depth.
        return {value * noise.sigma_m(0), value * (noise.sigma_m(1) - noise.sigma_m(0))};
      case ToleranceKind::kLossless:
        break;
    }
    return {};
  }
  /// The same at a depth [m].
  double bound_m(double depth_m) const noexcept { return bound_curve().at(depth_m); }
};

/// x and y of a pixel's ray (x, y, 1).
struct Ray {
  double x = 0, y = 0;
};

/// The largest distance of a lossless cloud's point from the one that its count gives back: three
/// coordinates to the last bits of a float.
constexpr double kExactResidual_m = 2e-6;

/// How far points are from where their pixel's ray and their count put them.
struct CloudFit {
  double worst_m = 0;        ///< largest distance, rounding to the grid included [m]
  double worst_share = 0;    ///< largest distance over that point's bound; infinite for bound 0
  double lateral_share = 0;  ///< the same for the distance from the ray alone
};

/// Squared distance of a point from the one that lies on its pixel's ray at `depth` [m^2].
inline double misfit_square_m2(const OpticalAxes& axes, const Ray& ray, const Point3f& point,
                               double depth) noexcept {
  const auto made = axes.point(ray.x, ray.y, depth);
  const double x = double{point.x} - made.x, y = double{point.y} - made.y;
  const double z = double{point.z} - made.z;
  return x * x + y * y + z * z;
}

/// Measures all readings with counts between the limits. `depth` holds the cloud's counts. O(n).
CloudFit measure_fit(const StreamConfig& config, const RayTable& rays, const Contract& contract,
                     std::span<const Point3f> points, std::span<const std::uint16_t> depth,
                     std::uint16_t least, std::uint16_t most) noexcept;

}  // namespace planecast
