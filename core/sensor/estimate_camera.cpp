#include "core/sensor/estimate_camera.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <vector>

namespace planecast {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr std::size_t kMinPoints = 16;
// A float32 coordinate at 50 m is exact to 2 um: a fit this good cannot be bettered by turning.
constexpr double kTinyResidual_m = 5e-6;
// A point agrees with a fit when it misses by at most this many medians (or the tiny residual).
constexpr double kInlierMedians = 5;
// A richer model must be this much better before it is believed.
constexpr double kWorthwhile = 0.5;
constexpr int kRefinements = 30;
// Fits use about this many points, spread evenly; the report uses all of them.
constexpr std::size_t kFitPoints = 30'000;

struct Sample {
  double u, v;
  Vector3d p;
};

// p = rotation * z * (ax u + bx, ay v + by, 1) + translation; rotation may mirror (det -1).
struct Fit {
  double ax = 0, bx = 0, ay = 0, by = 0;
  Matrix3d rotation = Matrix3d::Identity();
  Vector3d translation = Vector3d::Zero();
};

// Points that have a reading; some recorders write holes as the origin.
std::vector<Sample> valid_samples(const PointCloud& cloud) {
  std::vector<Sample> samples;
  samples.reserve(cloud.points.size());
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    const Point3f& p = cloud.points[i];
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) continue;
    if (p.x == 0 && p.y == 0 && p.z == 0) continue;
    samples.push_back({static_cast<double>(i % cloud.width), static_cast<double>(i / cloud.width),
                       Vector3d(p.x, p.y, p.z)});
  }
  return samples;
}

double inlier_limit(double median) {
  return std::max(kTinyResidual_m, kInlierMedians * median);
}

bool usable(const Fit& fit) {
  const bool positive = fit.ax > 0 && fit.ay > 0;
  return positive && std::isfinite(fit.bx) && std::isfinite(fit.by) && fit.rotation.allFinite() &&
         fit.translation.allFinite();
}

struct Miss {
  double metres, pixels;
};

// How far a point lies from its pixel's ray at its own z. Behind the camera there is no pixel: the
// whole distance counts.
Miss miss_of(const Fit& fit, const Sample& s) {
  const Vector3d q = fit.rotation.transpose() * (s.p - fit.translation);
  if (!(q.z() > 0)) return {q.norm(), 0};
  const double ex = q.x() / q.z() - (fit.ax * s.u + fit.bx);
  const double ey = q.y() / q.z() - (fit.ay * s.v + fit.by);
  return {q.z() * std::hypot(ex, ey), std::hypot(ex / fit.ax, ey / fit.ay)};
}

// Distances of all samples [m], and the one that half of them stay below.
double median_miss(const Fit& fit, const std::vector<Sample>& samples,
                   std::vector<double>& misses) {
  misses.clear();
  for (const Sample& s : samples) misses.push_back(miss_of(fit, s).metres);
  std::vector<double> sorted = misses;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  return *middle;
}

// Least squares of value ~ z (a pixel + b); false when the pixels do not vary.
bool fit_axis(const std::vector<Sample>& samples, double Sample::*pixel, int axis, double& a,
              double& b) {
  double zz = 0, zzu = 0, zzuu = 0, zx = 0, zxu = 0;
  for (const Sample& s : samples) {
    const double u = s.*pixel;
    const double z = s.p.z();
    zz += z * z;
    zzu += z * z * u;
    zzuu += z * z * u * u;
    zx += z * s.p[axis];
    zxu += z * s.p[axis] * u;
  }
  const double det = zzuu * zz - zzu * zzu;
  if (!(det > 1e-12 * zzuu * zz)) return false;
  a = (zxu * zz - zx * zzu) / det;
  b = (zx * zzuu - zxu * zzu) / det;
  return true;
}

std::optional<Fit> fit_pinhole(const std::vector<Sample>& samples) {
  Fit fit;
  if (!fit_axis(samples, &Sample::u, 0, fit.ax, fit.bx) ||
      !fit_axis(samples, &Sample::v, 1, fit.ay, fit.by) || !usable(fit)) {
    return std::nullopt;
  }
  return fit;
}

// Splits a 3x3 that maps cloud directions to (skewed) pixels, K * R^T times any factor, into an
// upper triangular K with positive diagonal and an orthogonal R: row by row from the last, by Gram
// and Schmidt. Eigen's QR and LU of such small matrices took a third of this file's compile time.
std::optional<Fit> split_projection(const Matrix3d& projection) {
  Matrix3d k = Matrix3d::Zero();
  Matrix3d to_optical = Matrix3d::Zero();
  for (int row = 2; row >= 0; --row) {
    Vector3d rest = projection.row(row).transpose();
    for (int done = 2; done > row; --done) {
      const Vector3d direction = to_optical.row(done).transpose();
      k(row, done) = rest.dot(direction);
      rest -= k(row, done) * direction;
    }
    k(row, row) = rest.norm();
    to_optical.row(row) = (rest / k(row, row)).transpose();
  }
  Fit fit;
  fit.ax = k(2, 2) / k(0, 0);
  fit.ay = k(2, 2) / k(1, 1);
  fit.bx = -k(0, 2) / k(0, 0);
  fit.by = -k(1, 2) / k(1, 1);
  fit.rotation = to_optical.transpose();
  return usable(fit) ? std::optional<Fit>(fit) : std::nullopt;
}

// Direct linear transform: the 3 x columns matrix P with (u, v, 1) ~ P h(p), h = p (3) or (p, 1)
// (4), as the smallest eigenvector of the normal matrix. Pixels and points are scaled to about 1
// first. Sizes are known at run time only: unrolled, two of them took a compiler half a minute.
Eigen::MatrixXd direct_linear(int columns, const std::vector<Sample>& samples, double scale_px,
                              const Vector3d& centre, double scale_m) {
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(3 * columns, 3 * columns);
  Eigen::VectorXd h = Eigen::VectorXd::Ones(columns);
  Eigen::VectorXd along_u = Eigen::VectorXd::Zero(3 * columns), along_v = along_u;
  for (const Sample& s : samples) {
    h.head<3>() = (s.p - centre) / scale_m;
    if (columns == 3) h.normalize();
    along_u.head(columns) = h;
    along_u.tail(columns) = -s.u / scale_px * h;
    along_v.segment(columns, columns) = h;
    along_v.tail(columns) = -s.v / scale_px * h;
    normal.selfadjointView<Eigen::Lower>().rankUpdate(along_u);
    normal.selfadjointView<Eigen::Lower>().rankUpdate(along_v);
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(normal);
  const Eigen::VectorXd best = solver.eigenvectors().col(0);
  Eigen::MatrixXd projection(3, columns);
  for (int row = 0; row < 3; ++row)
    projection.row(row) = best.segment(row * columns, columns).transpose();
  projection.topRows(2) *= scale_px;
  return projection;
}

std::optional<Fit> guess_rotated(double scale_px, const std::vector<Sample>& samples) {
  Matrix3d projection = direct_linear(3, samples, scale_px, Vector3d::Zero(), 1.0);
  double side = 0;  // the sign that puts the points in front of the camera
  for (const Sample& s : samples) side += projection.row(2).dot(s.p) > 0 ? 1 : -1;
  if (side < 0) projection = -projection;
  return split_projection(projection);
}

std::optional<Fit> guess_moved(double scale_px, const std::vector<Sample>& samples) {
  Vector3d centre = Vector3d::Zero();
  for (const Sample& s : samples) centre += s.p;
  centre /= static_cast<double>(samples.size());
  double spread = 0;
  for (const Sample& s : samples) spread += (s.p - centre).squaredNorm();
  spread = std::sqrt(spread / static_cast<double>(samples.size()));
  if (!(spread > 0)) return std::nullopt;
  Eigen::Matrix<double, 3, 4> projection = direct_linear(4, samples, scale_px, centre, spread);
  double side = 0;
  for (const Sample& s : samples) {
    const Vector3d h = (s.p - centre) / spread;
    side += projection.row(2).head<3>().dot(h) + projection(2, 3) > 0 ? 1 : -1;
  }
  if (side < 0) projection = -projection;
  std::optional<Fit> fit = split_projection(projection.leftCols<3>());
  if (!fit) return std::nullopt;
  const Vector3d eye = -(projection.leftCols<3>().inverse() * projection.col(3));
  fit->translation = centre + spread * eye;
  return usable(*fit) ? fit : std::nullopt;
}

Matrix3d cross_matrix(const Vector3d& w) {
  Matrix3d out;
  out << 0, -w.z(), w.y(), w.z(), 0, -w.x(), -w.y(), w.x(), 0;
  return out;
}

Matrix3d rotation_of(const Vector3d& w) {
  return Eigen::AngleAxisd(w.norm(), w.stableNormalized()).toRotationMatrix();
}

// One Gauss-Newton step on the lateral distances, at each point's own z, of the samples that miss
// by at most `limit`. Unknowns, of which the first 4, 7 or 10 are free: ax, bx, ay, by, turn,
// shift.
bool step(Fit& fit, const std::vector<Sample>& samples, const std::vector<double>& misses,
          double limit, int unknowns) {
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(10, 10);
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(10), row(10);
  const Matrix3d to_optical = fit.rotation.transpose();
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (misses[i] > limit) continue;
    const Sample& s = samples[i];
    const Vector3d q = to_optical * (s.p - fit.translation);
    const Matrix3d turn = cross_matrix(q);  // dq / dw for rotation * exp(w)
    const double slope[2] = {fit.ax * s.u + fit.bx, fit.ay * s.v + fit.by};
    for (int axis = 0; axis < 2; ++axis) {
      row.setZero();
      row[2 * axis] = -q.z() * (axis == 0 ? s.u : s.v);
      row[2 * axis + 1] = -q.z();
      row.segment<3>(4) = (turn.row(axis) - slope[axis] * turn.row(2)).transpose();
      row.segment<3>(7) = -(to_optical.row(axis) - slope[axis] * to_optical.row(2)).transpose();
      normal.selfadjointView<Eigen::Lower>().rankUpdate(row);
      gradient += (q[axis] - q.z() * slope[axis]) * row;
    }
  }
  normal = Eigen::MatrixXd(normal.selfadjointView<Eigen::Lower>());
  // Scaled to a unit diagonal, so that metres, radians and slopes per pixel weigh alike.
  const Eigen::VectorXd scale = normal.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled =
      (scale.asDiagonal() * normal * scale.asDiagonal()).topLeftCorner(unknowns, unknowns);
  const Eigen::VectorXd right = -(scale.asDiagonal() * gradient).head(unknowns);
  Eigen::VectorXd change = Eigen::VectorXd::Zero(10);
  change.head(unknowns) = scale.head(unknowns).asDiagonal() * scaled.ldlt().solve(right);
  fit.ax += change[0];
  fit.bx += change[1];
  fit.ay += change[2];
  fit.by += change[3];
  fit.rotation = fit.rotation * rotation_of(change.segment<3>(4));
  fit.translation += change.segment<3>(7);
  return usable(fit);
}

// Least trimmed squares: each step fits the better half of the points, so that pixels whose points
// are not on their ray (some drivers fill holes so) do not pull. A last step takes all that agree.
// Returns the median distance.
double refine(Fit& fit, const std::vector<Sample>& samples, int unknowns) {
  std::vector<double> misses;
  double median = median_miss(fit, samples, misses);
  for (int i = 0; i < kRefinements; ++i) {
    Fit next = fit;
    if (!step(next, samples, misses, median, unknowns)) break;
    std::vector<double> next_misses;
    const double next_median = median_miss(next, samples, next_misses);
    if (!(next_median < median)) break;
    fit = next;
    misses.swap(next_misses);
    median = next_median;
  }
  Fit next = fit;
  if (step(next, samples, misses, inlier_limit(median), unknowns)) {
    const double next_median = median_miss(next, samples, misses);
    if (next_median < 1.1 * median) {
      fit = next;
      return next_median;
    }
  }
  return median;
}

void measure(const Fit& fit, const std::vector<Sample>& samples, double median,
             EstimatedCamera& out) {
  double sum_m = 0;
  double sum_px = 0;
  for (const Sample& s : samples) {
    const Miss miss = miss_of(fit, s);
    out.max_residual_m = std::max(out.max_residual_m, miss.metres);
    out.max_residual_px = std::max(out.max_residual_px, miss.pixels);
    sum_m += miss.metres * miss.metres;
    sum_px += miss.pixels * miss.pixels;
    if (miss.metres > inlier_limit(median)) continue;
    ++out.inliers;
    out.inlier_max_residual_m = std::max(out.inlier_max_residual_m, miss.metres);
  }
  out.points = samples.size();
  out.rms_residual_m = std::sqrt(sum_m / static_cast<double>(samples.size()));
  out.rms_residual_px = std::sqrt(sum_px / static_cast<double>(samples.size()));
}

EstimatedCamera to_camera(const Fit& fit, EstimatedCamera::Model model) {
  EstimatedCamera out;
  out.intrinsics.fx = 1 / fit.ax;
  out.intrinsics.fy = 1 / fit.ay;
  out.intrinsics.cx = -fit.bx / fit.ax;
  out.intrinsics.cy = -fit.by / fit.ay;
  Matrix3d rotation = fit.rotation;
  out.mirror_y = rotation.determinant() < 0;
  if (out.mirror_y) rotation.col(1) *= -1;
  const Eigen::Quaterniond q = Eigen::Quaterniond(rotation).normalized();
  const Vector3d& t = fit.translation;
  out.cloud_from_optical = {q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z()};
  out.model = model;
  return out;
}

// Keeps the best model seen; a later, richer one must be clearly better.
class Choice {
 public:
  explicit Choice(const std::vector<Sample>& samples) : samples_(samples) {}

  void offer(std::optional<Fit> fit, EstimatedCamera::Model model) {
    if (!fit) return;
    const double median = refine(*fit, samples_, 4 + 3 * static_cast<int>(model));
    if (best_ && !(median < kWorthwhile * median_)) return;
    best_ = *fit;
    model_ = model;
    median_ = median;
  }

  bool settled() const { return best_ && median_ <= kTinyResidual_m; }

  std::optional<EstimatedCamera> report(const std::vector<Sample>& all) const {
    if (!best_) return std::nullopt;
    EstimatedCamera out = to_camera(*best_, model_);
    measure(*best_, all, median_, out);
    return out;
  }

 private:
  const std::vector<Sample>& samples_;
  std::optional<Fit> best_;
  EstimatedCamera::Model model_ = EstimatedCamera::Model::kPinhole;
  double median_ = 0;
};

// Every n-th point; n is odd so that even image widths do not leave columns out.
std::vector<Sample> thinned(const std::vector<Sample>& all) {
  const std::size_t stride = (all.size() / kFitPoints) | 1U;
  std::vector<Sample> some;
  for (std::size_t i = 0; i < all.size(); i += stride) some.push_back(all[i]);
  return some;
}

Error cannot(const std::string& why) {
  return {Status::kBadConfig,
          "the camera cannot be estimated: " + why + "; give it as --camera FX,FY,CX,CY"};
}

}  // namespace

std::string EstimatedCamera::describe() const {
  const char* kinds[] = {"in optical axes", "turned", "turned and shifted"};
  char text[320];
  std::snprintf(text, sizeof text,
                "camera estimated from %llu points: f %.3f,%.3f centre %.3f,%.3f, cloud %s%s; "
                "%llu points agree within %.3g m, all within %.3g m (rms %.3g m)",
                static_cast<unsigned long long>(points), intrinsics.fx, intrinsics.fy,
                intrinsics.cx, intrinsics.cy, kinds[static_cast<int>(model)],
                mirror_y ? ", y mirrored" : "", static_cast<unsigned long long>(inliers),
                inlier_max_residual_m, max_residual_m, rms_residual_m);
  return text;
}

Result<EstimatedCamera> estimate_camera(const PointCloud& cloud) {
  if (!cloud.organised() || cloud.width < 2 ||
      cloud.points.size() != std::size_t{cloud.width} * cloud.height) {
    return cannot("the cloud has no grid of at least 2 x 2 pixels");
  }
  const std::vector<Sample> all = valid_samples(cloud);
  if (all.size() < kMinPoints)
    return cannot("only " + std::to_string(all.size()) + " valid points");
  const auto in_line = [&](double Sample::*pixel) {
    return std::all_of(all.begin(), all.end(),
                       [&](const Sample& s) { return s.*pixel == all[0].*pixel; });
  };
  if (in_line(&Sample::u) || in_line(&Sample::v)) return cannot("all points lie in one line");
  using Model = EstimatedCamera::Model;
  const std::vector<Sample> some = thinned(all);
  const double scale_px = 0.5 * std::max(cloud.width, cloud.height);
  Choice choice(some);
  choice.offer(fit_pinhole(some), Model::kPinhole);
  if (!choice.settled()) choice.offer(guess_rotated(scale_px, some), Model::kRotated);
  if (!choice.settled()) choice.offer(guess_moved(scale_px, some), Model::kMoved);
  if (const auto best = choice.report(all)) return *best;
  return cannot("no pinhole camera explains the points");
}

}  // namespace planecast
