#include "core/metrics/distance.hpp"

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "core/search/kdtree_search.hpp"

namespace planecast {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Second eigenvalue below this share of the first: the points lie on a line, no plane is meant.
constexpr double kLineShare = 1e-6;

bool finite(const Point3f& p) noexcept {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

Eigen::Vector3d vector_of(const Point3f& p) {
  return {p.x, p.y, p.z};
}

/// Unit normal of the plane through the k points nearest to `at`; zero when they span none.
Eigen::Vector3d normal_at(const KdTreeSearch& tree, std::span<const Point3f> points,
                          const Point3f& at, std::span<Neighbour> scratch) {
  const std::size_t count = tree.knn(at, scratch);
  if (count < 3) return Eigen::Vector3d::Zero();
  const Eigen::Vector3d origin = vector_of(at);  // sums near zero keep their digits
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  for (const Neighbour& n : scratch.first(count)) {
    const Eigen::Vector3d d = vector_of(points[n.index]) - origin;
    sum += d;
    squares += d * d.transpose();
  }
  const double share = 1.0 / static_cast<double>(count);
  const Eigen::Vector3d mean = sum * share;
  const Eigen::Matrix3d covariance = squares * share - mean * mean.transpose();
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(covariance);
  const Eigen::Vector3d& values = solver.eigenvalues();  // ascending
  if (!(values[2] > 0.0) || values[1] <= kLineShare * values[2]) return Eigen::Vector3d::Zero();
  const Eigen::Vector3d normal = solver.eigenvectors().col(0);
  return normal.allFinite() ? normal : Eigen::Vector3d::Zero();
}

/// Distance of two points along a normal; the whole distance when there is no normal.
double along(const Eigen::Vector3d& normal, const Point3f& p, const Point3f& q) {
  const Eigen::Vector3d d = vector_of(p) - vector_of(q);
  return normal.isZero() ? d.norm() : std::abs(normal.dot(d));
}

/// Root mean square and maximum of a stream of distances.
struct Spread {
  double sum_sq = 0;
  double max_sq = 0;
  std::size_t count = 0;

  void add_sq(double sq) noexcept {
    sum_sq += sq;
    max_sq = std::max(max_sq, sq);
    ++count;
  }
  double rms() const noexcept {
    return count == 0 ? 0.0 : std::sqrt(sum_sq / static_cast<double>(count));
  }
};

/// Walks `from` to its nearest points in `to` and gives each pair to `visit`.
template <class Visit>
Spread walk(std::span<const Point3f> from, const KdTreeSearch& to, Visit&& visit) {
  Spread spread;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const Neighbour n = to.nearest(from[i]);
    if (!n.found()) continue;  // the point is not finite
    spread.add_sq(n.sq_dist);
    visit(i, n.index);
  }
  return spread;
}

CloudDistance all_infinite(std::size_t points_a, std::size_t points_b, bool point_to_plane) {
  CloudDistance result;
  result.points_a = points_a;
  result.points_b = points_b;
  result.d1_ab = result.d1_ba = result.d1 = kInfinity;
  if (point_to_plane) result.d2_ab = result.d2_ba = result.d2 = kInfinity;
  result.hausdorff_ab = result.hausdorff_ba = result.hausdorff = kInfinity;
  return result;
}

}  // namespace

CloudDistance cloud_distance(std::span<const Point3f> original, std::span<const Point3f> decoded,
                             const DistanceOptions& options) {
  const KdTreeSearch tree_a(original);
  const KdTreeSearch tree_b(decoded);
  if (tree_a.size() == 0 && tree_b.size() == 0) return {};
  if (tree_a.size() == 0 || tree_b.size() == 0)
    return all_infinite(tree_a.size(), tree_b.size(), options.point_to_plane);

  const bool planes = options.point_to_plane;
  std::vector<Eigen::Vector3d> normals(planes ? original.size() : 0, Eigen::Vector3d::Zero());
  std::vector<Neighbour> scratch(std::max<std::size_t>(options.normal_k, 3));
  Spread plane_ab;
  Spread plane_ba;
  const Spread ab = walk(original, tree_b, [&](std::size_t a, std::size_t b) {
    if (!planes) return;
    normals[a] = normal_at(tree_a, original, original[a], scratch);
    const double distance = along(normals[a], original[a], decoded[b]);
    plane_ab.add_sq(distance * distance);
  });
  const Spread ba = walk(decoded, tree_a, [&](std::size_t b, std::size_t a) {
    if (!planes) return;
    const double distance = along(normals[a], decoded[b], original[a]);
    plane_ba.add_sq(distance * distance);
  });

  CloudDistance result;
  result.points_a = tree_a.size();
  result.points_b = tree_b.size();
  result.d1_ab = ab.rms();
  result.d1_ba = ba.rms();
  result.d1 = 0.5 * (result.d1_ab + result.d1_ba);
  result.d2_ab = plane_ab.rms();
  result.d2_ba = plane_ba.rms();
  result.d2 = 0.5 * (result.d2_ab + result.d2_ba);
  result.hausdorff_ab = std::sqrt(ab.max_sq);
  result.hausdorff_ba = std::sqrt(ba.max_sq);
  result.hausdorff = std::max(result.hausdorff_ab, result.hausdorff_ba);
  return result;
}

Result<CorrespondingDistance> max_corresponding(std::span<const Point3f> original,
                                                std::span<const Point3f> decoded) {
  if (original.size() != decoded.size()) {
    return {Status::kWrongSize, "the clouds have " + std::to_string(original.size()) + " and " +
                                    std::to_string(decoded.size()) +
                                    " points, so they do not correspond point by point"};
  }
  CorrespondingDistance result;
  Spread spread;
  for (std::size_t i = 0; i < original.size(); ++i) {
    const bool in_original = finite(original[i]);
    const bool in_decoded = finite(decoded[i]);
    if (in_original != in_decoded) ++(in_original ? result.only_original : result.only_decoded);
    if (!in_original || !in_decoded) continue;
    const double sq = (vector_of(original[i]) - vector_of(decoded[i])).squaredNorm();
    if (sq > spread.max_sq) result.worst_index = i;
    spread.add_sq(sq);
  }
  result.compared = spread.count;
  result.max = std::sqrt(spread.max_sq);
  result.rmse = spread.rms();
  return result;
}

}  // namespace planecast
