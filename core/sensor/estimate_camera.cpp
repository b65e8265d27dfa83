#include "core/sensor/estimate_camera.hpp"

#include <Eigen/Dense>
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
// A richer model must be this much better before it is believed.
constexpr double kWorthwhile = 0.5;
constexpr int kRefinements = 12;

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

struct Residuals {
  double max_m = 0, rms_m = 0, max_px = 0, rms_px = 0;
};

std::vector<Sample> valid_samples(const PointCloud& cloud) {
  std::vector<Sample> samples;
  samples.reserve(cloud.points.size());
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    const Point3f& p = cloud.points[i];
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) continue;
    if (p.x == 0 && p.y == 0 && p.z == 0) continue;  // some recorders write holes as the origin
    samples.push_back({static_cast<double>(i % cloud.width), static_cast<double>(i / cloud.width),
                       Vector3d(p.x, p.y, p.z)});
  }
  return samples;
}

bool usable(const Fit& fit) {
  const bool positive = fit.ax > 0 && fit.ay > 0;
  return positive && std::isfinite(fit.bx) && std::isfinite(fit.by) && fit.rotation.allFinite() &&
         fit.translation.allFinite();
}

// A point behind the camera has no pixel: such a fit is worthless.
std::optional<Residuals> measure(const Fit& fit, const std::vector<Sample>& samples) {
  Residuals out;
  double sum_m = 0;
  double sum_px = 0;
  const Matrix3d to_optical = fit.rotation.transpose();
  for (const Sample& s : samples) {
    const Vector3d q = to_optical * (s.p - fit.translation);
    if (!(q.z() > 0)) return std::nullopt;
    const double ex = q.x() / q.z() - (fit.ax * s.u + fit.bx);
    const double ey = q.y() / q.z() - (fit.ay * s.v + fit.by);
    const double metres = q.z() * std::hypot(ex, ey);
    const double pixels = std::hypot(ex / fit.ax, ey / fit.ay);
    out.max_m = std::max(out.max_m, metres);
    out.max_px = std::max(out.max_px, pixels);
    sum_m += metres * metres;
    sum_px += pixels * pixels;
  }
  const auto count = static_cast<double>(samples.size());
  out.rms_m = std::sqrt(sum_m / count);
  out.rms_px = std::sqrt(sum_px / count);
  return out;
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
// upper triangular K with positive diagonal and an orthogonal R (RQ decomposition).
std::optional<Fit> split_projection(const Matrix3d& projection) {
  Matrix3d flip = Matrix3d::Zero();
  flip(0, 2) = flip(1, 1) = flip(2, 0) = 1;
  const Eigen::HouseholderQR<Matrix3d> qr((flip * projection).transpose());
  const Matrix3d q = qr.householderQ();
  const Matrix3d r = qr.matrixQR().triangularView<Eigen::Upper>();
  Matrix3d k = flip * r.transpose() * flip;
  Matrix3d to_optical = flip * q.transpose();
  for (int i = 0; i < 3; ++i) {
    if (k(i, i) >= 0) continue;
    k.col(i) *= -1;
    to_optical.row(i) *= -1;
  }
  Fit fit;
  fit.ax = k(2, 2) / k(0, 0);
  fit.ay = k(2, 2) / k(1, 1);
  fit.bx = -k(0, 2) / k(0, 0);
  fit.by = -k(1, 2) / k(1, 1);
  fit.rotation = to_optical.transpose();
  return usable(fit) ? std::optional<Fit>(fit) : std::nullopt;
}

// Direct linear transform: the 3 x Columns matrix P with (u, v, 1) ~ P h(p), h = p or (p, 1), as
// the smallest eigenvector of the normal matrix. Pixels and points are scaled to about 1 first.
template <int Columns>
Eigen::Matrix<double, 3, Columns> direct_linear(const std::vector<Sample>& samples, double scale_px,
                                                const Vector3d& centre, double scale_m) {
  constexpr int kUnknowns = 3 * Columns;
  using Row = Eigen::Matrix<double, kUnknowns, 1>;
  Eigen::Matrix<double, kUnknowns, kUnknowns> normal;
  normal.setZero();
  for (const Sample& s : samples) {
    Eigen::Matrix<double, Columns, 1> h;
    h.template head<3>() = (s.p - centre) / scale_m;
    if constexpr (Columns == 4) h[3] = 1;
    if constexpr (Columns == 3) h.normalize();
    Row along_u = Row::Zero();
    Row along_v = Row::Zero();
    along_u.template head<Columns>() = h;
    along_u.template tail<Columns>() = -s.u / scale_px * h;
    along_v.template segment<Columns>(Columns) = h;
    along_v.template tail<Columns>() = -s.v / scale_px * h;
    normal.template selfadjointView<Eigen::Lower>().rankUpdate(along_u);
    normal.template selfadjointView<Eigen::Lower>().rankUpdate(along_v);
  }
  const Eigen::SelfAdjointEigenSolver<decltype(normal)> solver(normal);
  const Row best = solver.eigenvectors().col(0);
  Eigen::Matrix<double, 3, Columns> projection;
  for (int row = 0; row < 3; ++row) {
    projection.row(row) = best.template segment<Columns>(row * Columns).transpose();
  }
  projection.template topRows<2>() *= scale_px;
  return projection;
}

double pixel_scale(const PointCloud& cloud) {
  return 0.5 * std::max(cloud.width, cloud.height);
}

std::optional<Fit> guess_rotated(const PointCloud& cloud, const std::vector<Sample>& samples) {
  Matrix3d projection = direct_linear<3>(samples, pixel_scale(cloud), Vector3d::Zero(), 1.0);
  double side = 0;  // the sign that puts the points in front of the camera
  for (const Sample& s : samples) side += projection.row(2).dot(s.p) > 0 ? 1 : -1;
  if (side < 0) projection = -projection;
  return split_projection(projection);
}

std::optional<Fit> guess_moved(const PointCloud& cloud, const std::vector<Sample>& samples) {
  Vector3d centre = Vector3d::Zero();
  for (const Sample& s : samples) centre += s.p;
  centre /= static_cast<double>(samples.size());
  double spread = 0;
  for (const Sample& s : samples) spread += (s.p - centre).squaredNorm();
  spread = std::sqrt(spread / static_cast<double>(samples.size()));
  if (!(spread > 0)) return std::nullopt;
  Eigen::Matrix<double, 3, 4> projection =
      direct_linear<4>(samples, pixel_scale(cloud), centre, spread);
  double side = 0;
  for (const Sample& s : samples) {
    const Vector3d h = (s.p - centre) / spread;
    side += projection.row(2).head<3>().dot(h) + projection(2, 3) > 0 ? 1 : -1;
  }
  if (side < 0) projection = -projection;
  std::optional<Fit> fit = split_projection(projection.leftCols<3>());
  if (!fit) return std::nullopt;
  const Vector3d eye = -projection.leftCols<3>().fullPivLu().solve(projection.col(3));
  fit->translation = centre + spread * eye;
  return usable(*fit) ? fit : std::nullopt;
}

Matrix3d cross_matrix(const Vector3d& w) {
  Matrix3d out;
  out << 0, -w.z(), w.y(), w.z(), 0, -w.x(), -w.y(), w.x(), 0;
  return out;
}

Matrix3d rotation_of(const Vector3d& w) {
  const double angle = w.norm();
  if (angle < 1e-300) return Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, w / angle).toRotationMatrix();
}

// One Gauss-Newton step on the lateral distances at each point's own z. Unknowns: ax, bx, ay, by, a
// small turn and, when `moved`, a shift.
bool refine_once(Fit& fit, const std::vector<Sample>& samples, bool moved) {
  using Vector10 = Eigen::Matrix<double, 10, 1>;
  Eigen::Matrix<double, 10, 10> normal;
  normal.setZero();
  Vector10 gradient = Vector10::Zero();
  const Matrix3d to_optical = fit.rotation.transpose();
  for (const Sample& s : samples) {
    const Vector3d q = to_optical * (s.p - fit.translation);
    const Matrix3d turn = cross_matrix(q);  // dq / dw for rotation * exp(w)
    const double slope[2] = {fit.ax * s.u + fit.bx, fit.ay * s.v + fit.by};
    for (int axis = 0; axis < 2; ++axis) {
      const double error = q[axis] - q.z() * slope[axis];
      Vector10 row = Vector10::Zero();
      row[2 * axis] = -q.z() * (axis == 0 ? s.u : s.v);
      row[2 * axis + 1] = -q.z();
      row.segment<3>(4) = (turn.row(axis) - slope[axis] * turn.row(2)).transpose();
      row.segment<3>(7) = -(to_optical.row(axis) - slope[axis] * to_optical.row(2)).transpose();
      normal.selfadjointView<Eigen::Lower>().rankUpdate(row);
      gradient += error * row;
    }
  }
  const int unknowns = moved ? 10 : 7;
  normal = normal.selfadjointView<Eigen::Lower>();
  // Scaled to a unit diagonal, so that metres, radians and slopes per pixel weigh alike.
  const Vector10 scale = normal.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled =
      (scale.asDiagonal() * normal * scale.asDiagonal()).topLeftCorner(unknowns, unknowns);
  const Eigen::VectorXd right = -(scale.asDiagonal() * gradient).head(unknowns);
  Vector10 step = Vector10::Zero();
  step.head(unknowns) = scale.head(unknowns).asDiagonal() * scaled.ldlt().solve(right);
  if (!step.allFinite()) return false;
  Fit next = fit;
  next.ax += step[0];
  next.bx += step[1];
  next.ay += step[2];
  next.by += step[3];
  next.rotation = fit.rotation * rotation_of(step.segment<3>(4));
  next.translation += step.segment<3>(7);
  if (!usable(next)) return false;
  fit = next;
  return true;
}

// Refines while the residual falls; returns it, or nothing when points lie behind the camera.
std::optional<Residuals> refine(Fit& fit, const std::vector<Sample>& samples, bool moved) {
  std::optional<Residuals> best = measure(fit, samples);
  for (int i = 0; i < kRefinements; ++i) {
    Fit next = fit;
    if (!refine_once(next, samples, moved)) break;
    const std::optional<Residuals> now = measure(next, samples);
    if (!now || (best && now->rms_m >= best->rms_m)) break;
    const bool settled = best && now->rms_m > 0.999 * best->rms_m;
    fit = next;
    best = now;
    if (settled) break;
  }
  return best;
}

EstimatedCamera report(const Fit& fit, const Residuals& residuals, EstimatedCamera::Model model,
                       std::size_t points) {
  EstimatedCamera out;
  out.intrinsics.fx = 1 / fit.ax;
  out.intrinsics.fy = 1 / fit.ay;
  out.intrinsics.cx = -fit.bx / fit.ax;
  out.intrinsics.cy = -fit.by / fit.ay;
  Matrix3d rotation = fit.rotation;
  out.mirror_y = rotation.determinant() < 0;
  if (out.mirror_y) rotation.col(1) *= -1;
  const Eigen::Quaterniond q = Eigen::Quaterniond(rotation).normalized();
  out.cloud_from_optical = {
      q.w(), q.x(), q.y(), q.z(), fit.translation.x(), fit.translation.y(), fit.translation.z()};
  out.model = model;
  out.points = points;
  out.max_residual_m = residuals.max_m;
  out.rms_residual_m = residuals.rms_m;
  out.max_residual_px = residuals.max_px;
  out.rms_residual_px = residuals.rms_px;
  return out;
}

// Keeps the best model seen; a later, richer one must be clearly better.
class Choice {
 public:
  explicit Choice(const std::vector<Sample>& samples) : samples_(samples) {}

  void offer(std::optional<Fit> fit, EstimatedCamera::Model model) {
    if (!fit) return;
    const std::optional<Residuals> residuals =
        model == EstimatedCamera::Model::kPinhole
            ? measure(*fit, samples_)
            : refine(*fit, samples_, model == EstimatedCamera::Model::kMoved);
    if (!residuals || (best_ && residuals->rms_m > kWorthwhile * best_->rms_residual_m)) return;
    best_ = report(*fit, *residuals, model, samples_.size());
  }

  bool settled() const { return best_ && best_->max_residual_m <= kTinyResidual_m; }
  const std::optional<EstimatedCamera>& best() const { return best_; }

 private:
  const std::vector<Sample>& samples_;
  std::optional<EstimatedCamera> best_;
};

Error cannot(const std::string& why) {
  return {Status::kBadConfig,
          "the camera cannot be estimated: " + why + "; give it as --camera FX,FY,CX,CY"};
}

}  // namespace

std::string EstimatedCamera::describe() const {
  const char* kinds[] = {"in optical axes", "turned", "turned and shifted"};
  char text[256];
  std::snprintf(text, sizeof text,
                "camera estimated from %llu points: f %.3f,%.3f centre %.3f,%.3f, cloud %s%s, "
                "residual max %.3g m (%.3g px), rms %.3g m",
                static_cast<unsigned long long>(points), intrinsics.fx, intrinsics.fy,
                intrinsics.cx, intrinsics.cy, kinds[static_cast<int>(model)],
                mirror_y ? ", y mirrored" : "", max_residual_m, max_residual_px, rms_residual_m);
  return text;
}

Result<EstimatedCamera> estimate_camera(const PointCloud& cloud) {
  if (!cloud.organised() || cloud.width < 2 ||
      cloud.points.size() != std::size_t{cloud.width} * cloud.height) {
    return cannot("the cloud has no grid of at least 2 x 2 pixels");
  }
  const std::vector<Sample> samples = valid_samples(cloud);
  if (samples.size() < kMinPoints) {
    return cannot("only " + std::to_string(samples.size()) + " valid points");
  }
  using Model = EstimatedCamera::Model;
  Choice choice(samples);
  choice.offer(fit_pinhole(samples), Model::kPinhole);
  if (!choice.settled()) choice.offer(guess_rotated(cloud, samples), Model::kRotated);
  if (!choice.settled()) choice.offer(guess_moved(cloud, samples), Model::kMoved);
  if (!choice.best()) return cannot("no pinhole camera explains the points");
  return *choice.best();
}

}  // namespace planecast
