#include "apps/common/cloud_fit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/sensor/pose_fixed.hpp"

namespace planecast {

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

CloudFit measure_fit(const StreamConfig& config, const RayTable& rays, const Contract& contract,
                     std::span<const Point3f> points, std::span<const std::uint16_t> depth,
                     std::uint16_t least, std::uint16_t most) noexcept {
  const OpticalAxes axes(config);
  const double unit = static_cast<double>(config.camera.unit_pm) * 1e-12;
  const BoundCurve curve = contract.bound_curve();
  CloudFit fit;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (depth[i] == 0 || depth[i] < least || depth[i] > most) continue;
    const auto u = static_cast<std::uint32_t>(i % rays.width);
    const auto v = static_cast<std::uint32_t>(i / rays.width);
    const Ray ray{rays.x(u, v) * kRayUnit, rays.y(u, v) * kRayUnit};
    const double off = std::sqrt(misfit_square_m2(axes, ray, points[i], depth[i] * unit));
    fit.worst_m = std::max(fit.worst_m, off);
    if (contract.kind == ToleranceKind::kLossless) continue;
    const double at = axes.depth(points[i]);
    const double bound = curve.at(at);
    const double none = std::numeric_limits<double>::infinity();
    const double lateral = std::sqrt(misfit_square_m2(axes, ray, points[i], at));
    fit.worst_share = std::max(fit.worst_share, bound > 0 ? off / bound : none);
    fit.lateral_share = std::max(fit.lateral_share, bound > 0 ? lateral / bound : none);
  }
  return fit;
}

}  // namespace planecast
