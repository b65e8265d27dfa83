#include "core/segment/point_normals.hpp"

#include <algorithm>

#include "core/model/least_eigen.hpp"

namespace planecast {
namespace {

/// Sums over neighbours, relative to the point itself: small numbers keep their digits.
Symmetric3 covariance(const PointNeighbours& cloud, const std::uint8_t* removed, std::uint32_t n,
                      float& count) noexcept {
  const float px = cloud.x()[n], py = cloud.y()[n], pz = cloud.z()[n];
  const float *x = cloud.x().data(), *y = cloud.y().data(), *z = cloud.z().data();
  float sx = 0, sy = 0, sz = 0, xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
  count = 1;
  for (const std::uint32_t m : cloud.of(n)) {
    const float w = removed == nullptr ? 1.0F : static_cast<float>(1 - removed[m]);
    const float dx = (x[m] - px) * w, dy = (y[m] - py) * w, dz = (z[m] - pz) * w;
    count += w;
    sx += dx;
    sy += dy;
    sz += dz;
    xx += dx * dx;
    xy += dx * dy;
    xz += dx * dz;
    yy += dy * dy;
    yz += dy * dz;
    zz += dz * dz;
  }
  const double r = 1.0 / count, mx = sx * r, my = sy * r, mz = sz * r;
  return {xx * r - mx * mx, xy * r - mx * my, xz * r - mx * mz,
          yy * r - my * my, yz * r - my * mz, zz * r - mz * mz};
}

}  // namespace

Status estimate_normals(const PointNeighbours& cloud, std::span<const std::uint8_t> removed,
                        const PointNormals& normals) noexcept {
  const std::size_t n = cloud.size();
  if (removed.size() != n || normals.x.size() != n || normals.y.size() != n ||
      normals.z.size() != n || normals.curvature.size() != n) {
    return Status::kWrongSize;
  }
  const bool all = std::find(removed.begin(), removed.end(), 1) == removed.end();
  for (std::uint32_t i = 0; i < n; ++i) {
    normals.x[i] = normals.y[i] = normals.z[i] = 0;
    normals.curvature[i] = kNoCurvature;
    if (removed[i] != 0) continue;
    float count = 0;
    const Symmetric3 m = covariance(cloud, all ? nullptr : removed.data(), i, count);
    LeastEigen least;
    if (count < 3 || !least_eigen(m, least)) continue;
    normals.x[i] = static_cast<float>(least.x);
    normals.y[i] = static_cast<float>(least.y);
    normals.z[i] = static_cast<float>(least.z);
    normals.curvature[i] = static_cast<float>(least.share);
  }
  return Status::kOk;
}

}  // namespace planecast
