#include "core/metrics/roughness.hpp"

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/search/kdtree_search.hpp"

namespace planecast {
namespace {

// Least eigenvalue of the covariance of the points around `at`; < 0 when there are too few.
double least_variance(const KdTreeSearch& tree, std::span<const Point3f> points, const Point3f& at,
                      std::span<Neighbour> scratch) {
  const std::size_t count = tree.knn(at, scratch);
  if (count < 4) return -1;
  const Eigen::Vector3d origin(at.x, at.y, at.z);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  for (const Neighbour& n : scratch.first(count)) {
    const Point3f& p = points[n.index];
    const Eigen::Vector3d d = Eigen::Vector3d(p.x, p.y, p.z) - origin;
    sum += d;
    squares += d * d.transpose();
  }
  // A plane through n points takes three of their degrees of freedom.
  const auto n = static_cast<double>(count);
  const Eigen::Matrix3d scatter = squares - sum * sum.transpose() / n;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(scatter, Eigen::EigenvaluesOnly);
  return std::max(0.0, solver.eigenvalues()[0] / (n - 3));
}

}  // namespace

double surface_roughness_m(std::span<const Point3f> points, std::size_t samples, std::size_t k) {
  const KdTreeSearch tree(points);
  std::vector<Neighbour> scratch(k);
  std::vector<double> variances;
  const std::size_t step =
      std::max<std::size_t>(1, points.size() / std::max<std::size_t>(1, samples));
  for (std::size_t i = 0; i < points.size(); i += step) {
    const double variance = least_variance(tree, points, points[i], scratch);
    if (variance >= 0) variances.push_back(variance);
  }
  if (variances.empty()) return 0;
  const auto middle = variances.begin() + static_cast<std::ptrdiff_t>(variances.size() / 2);
  std::nth_element(variances.begin(), middle, variances.end());
  return std::sqrt(*middle);
}

}  // namespace planecast
