#include "apps/common/cloud_fit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/sensor/pose_fixed.hpp"

namespace planecast {
namespace {

constexpr double kRayUnit = 1.0 / 134217728.0;  // 2^-27

double distance(const Point3f& a, const Point3f& b) noexcept {
  const double x = double{a.x} - b.x, y = double{a.y} - b.y, z = double{a.z} - b.z;
  return std::sqrt(x * x + y * y + z * z);
}

Point3f on_ray(const OpticalAxes& axes, const RayTable& rays, PixelAt at, double depth) noexcept {
  return axes.point(rays.x(at.u, at.v) * kRayUnit, rays.y(at.u, at.v) * kRayUnit, depth);
}

}  // namespace

OpticalAxes::OpticalAxes(const StreamConfig& config)
    : identity_(config.axes == PoseFixed{} && !config.mirror_y), flip_y_(config.mirror_y ? -1 : 1) {
  const Pose p = to_pose(config.axes);
  const double w = p.qw, x = p.qx, y = p.qy, z = p.qz;
  const double rotation[3][3] = {
      {1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
      {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
      {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}};
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) m_[i][j] = rotation[i][j];
  }
  t_[0] = p.tx;
  t_[1] = p.ty;
  t_[2] = p.tz;
}

double OpticalAxes::depth(const Point3f& p) const noexcept {
  if (identity_) return p.z;
  return m_[0][2] * (p.x - t_[0]) + m_[1][2] * (p.y - t_[1]) + m_[2][2] * (p.z - t_[2]);
}

Point3f OpticalAxes::point(double x, double y, double depth) const noexcept {
  const double px = x * depth, py = flip_y_ * y * depth;
  if (identity_) return {static_cast<float>(px), static_cast<float>(py), static_cast<float>(depth)};
  return {static_cast<float>(m_[0][0] * px + m_[0][1] * py + m_[0][2] * depth + t_[0]),
          static_cast<float>(m_[1][0] * px + m_[1][1] * py + m_[1][2] * depth + t_[1]),
          static_cast<float>(m_[2][0] * px + m_[2][1] * py + m_[2][2] * depth + t_[2])};
}

Result<std::shared_ptr<const CameraRays>> camera_rays(const CameraModel& camera) {
  auto rays = std::make_shared<CameraRays>();
  rays->storage.resize(ray_table_entries(camera));
  if (build_ray_table(camera, rays->storage, rays->table) != Status::kOk) {
    return Error{Status::kBadConfig,
                 "the camera's distortion cannot be undone over the whole image; check the "
                 "coefficients of --distortion"};
  }
  return std::shared_ptr<const CameraRays>(std::move(rays));
}

double Contract::bound_m(double depth_m) const noexcept {
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

double misfit_m(const OpticalAxes& axes, const RayTable& rays, double metres_per_count,
                const Point3f& point, PixelAt at, std::uint16_t count) noexcept {
  return distance(point, on_ray(axes, rays, at, count * metres_per_count));
}

CloudFit measure_fit(const StreamConfig& config, const RayTable& rays, const Contract& contract,
                     std::span<const Point3f> points, std::span<const std::uint16_t> depth,
                     std::uint16_t least, std::uint16_t most) noexcept {
  const OpticalAxes axes(config);
  const double unit = static_cast<double>(config.camera.unit_pm) * 1e-12;
  CloudFit fit;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (depth[i] == 0 || depth[i] < least || depth[i] > most) continue;
    const PixelAt pixel{static_cast<std::uint32_t>(i % rays.width),
                        static_cast<std::uint32_t>(i / rays.width)};
    const double off = misfit_m(axes, rays, unit, points[i], pixel, depth[i]);
    fit.worst_m = std::max(fit.worst_m, off);
    if (contract.kind == ToleranceKind::kLossless) continue;
    const double at = axes.depth(points[i]);
    const double bound = contract.bound_m(at);
    const double none = std::numeric_limits<double>::infinity();
    const double lateral = distance(points[i], on_ray(axes, rays, pixel, at));
    fit.worst_share = std::max(fit.worst_share, bound > 0 ? off / bound : none);
    fit.lateral_share = std::max(fit.lateral_share, bound > 0 ? lateral / bound : none);
  }
  return fit;
}

}  // namespace planecast
