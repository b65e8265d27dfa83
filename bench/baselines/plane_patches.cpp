#include "bench/baselines/plane_patches.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <numeric>

#include "core/search/kdtree_search.hpp"

namespace planecast::baselines {
namespace {

constexpr std::size_t kWindow = 40;  // neighbours that make a normal, the point included
constexpr std::size_t kSteps = 12;   // of them that a patch may grow to
constexpr std::size_t kLeast = 50;   // points of a patch
constexpr double kAngle_deg = 15, kSpacings = 3;

Eigen::Vector3d at(const Point3f& p) {
  return {p.x, p.y, p.z};
}

// Running sums of a patch, and the plane through them.
struct PatchSums {
  Eigen::Vector3d first = Eigen::Vector3d::Zero(), sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  double count = 0;

  void add(const Eigen::Vector3d& p) {
    if (count == 0) first = p;
    const Eigen::Vector3d d = p - first;  // near the points: no digits lost to large offsets
    sum += d;
    squares += d * d.transpose();
    ++count;
  }
  Eigen::Vector3d mean() const { return first + sum / count; }
  // Eigenvectors of the covariance, least first; `curvature` takes the least one's share.
  Eigen::Matrix3d axes(double* curvature = nullptr) const {
    const Eigen::Vector3d m = sum / count;
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
    solver.compute(squares / count - m * m.transpose());
    if (curvature != nullptr) {
      const double total = solver.eigenvalues().sum();
      *curvature = total > 0 ? solver.eigenvalues()[0] / total : 1;
    }
    return solver.eigenvectors();
  }
};

struct Windows {
  std::vector<std::uint32_t> neighbours;  // kSteps a point
  std::vector<Eigen::Vector3d> normal;
  std::vector<double> curvature;
  double spacing = 0;  // median distance to the fourth neighbour
};

Windows make_windows(const PointList& points) {
  Windows out;
  const KdTreeSearch tree(points);
  out.neighbours.assign(points.size() * kSteps, Neighbour::kNone);
  out.normal.resize(points.size());
  out.curvature.resize(points.size());
  std::vector<double> spacings;
  std::array<Neighbour, kWindow> near;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::size_t found = tree.knn(points[i], near);
    PatchSums sums;
    for (std::size_t j = 0; j < found; ++j) {
      if (j < kSteps) out.neighbours[i * kSteps + j] = near[j].index;
      sums.add(at(points[near[j].index]));
    }
    out.normal[i] = sums.axes(&out.curvature[i]).col(0);
    if (found > 4) spacings.push_back(std::sqrt(near[4].sq_dist));
  }
  if (!spacings.empty()) {
    const auto middle = spacings.begin() + static_cast<std::ptrdiff_t>(spacings.size() / 2);
    std::nth_element(spacings.begin(), middle, spacings.end());
    out.spacing = *middle;
  }
  return out;
}

PlanePatch grow(const PointList& points, const Windows& windows, std::uint32_t seed,
                std::vector<std::uint8_t>& taken) {
  PlanePatch patch;
  PatchSums sums;
  Eigen::Vector3d normal = windows.normal[seed], origin = at(points[seed]);
  const double least_cosine = std::cos(kAngle_deg * static_cast<double>(EIGEN_PI) / 180);
  std::size_t refit = 2 * kWindow;
  patch.members.push_back(seed);
  taken[seed] = 1;
  sums.add(origin);
  for (std::size_t next = 0; next < patch.members.size(); ++next) {
    const std::uint32_t* near = &windows.neighbours[patch.members[next] * kSteps];
    for (std::size_t j = 0; j < kSteps && near[j] != Neighbour::kNone; ++j) {
      const std::uint32_t i = near[j];
      if (taken[i] != 0 || std::abs(windows.normal[i].dot(normal)) < least_cosine ||
          std::abs(normal.dot(at(points[i]) - origin)) > kSpacings * windows.spacing)
        continue;
      taken[i] = 1;
      patch.members.push_back(i);
      sums.add(at(points[i]));
    }
    if (patch.members.size() < refit) continue;
    normal = sums.axes().col(0);
    origin = sums.mean();
    refit *= 2;
  }
  const Eigen::Matrix3d axes = sums.axes();
  patch.origin = sums.mean();
  patch.n = axes.col(0);
  patch.u = axes.col(2);
  patch.v = patch.n.cross(patch.u);
  return patch;
}

}  // namespace

PlanePatches find_patches(const PointList& points) {
  PlanePatches out;
  const Windows windows = make_windows(points);
  std::vector<std::uint32_t> seeds(points.size());
  std::iota(seeds.begin(), seeds.end(), 0u);
  std::stable_sort(seeds.begin(), seeds.end(), [&](std::uint32_t a, std::uint32_t b) {
    return windows.curvature[a] < windows.curvature[b];
  });
  std::vector<std::uint8_t> taken(points.size(), 0);
  for (const std::uint32_t seed : seeds) {
    if (taken[seed] != 0) continue;
    PlanePatch patch = grow(points, windows, seed, taken);
    if (patch.members.size() >= kLeast) {
      out.patches.push_back(std::move(patch));
    } else {
      out.rest.insert(out.rest.end(), patch.members.begin(), patch.members.end());
    }
  }
  std::stable_sort(out.patches.begin(), out.patches.end(), [](const auto& a, const auto& b) {
    return a.members.size() > b.members.size();
  });
  return out;
}

}  // namespace planecast::baselines
