#include "core/model/least_eigen.hpp"

#include <algorithm>
#include <cmath>

namespace planecast {
namespace {

struct Vector {
  double x = 0, y = 0, z = 0;
  double square() const noexcept { return x * x + y * y + z * z; }
};

Vector cross(const Vector& a, const Vector& b) noexcept {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// Least eigenvalue of a positive semidefinite matrix of trace 1. Left of the least root the
/// characteristic polynomial rises and is concave, so Newton's steps from 0 never pass it.
double least_eigenvalue(const Symmetric3& m) noexcept {
  const double minors =
      m.xx * m.yy - m.xy * m.xy + m.xx * m.zz - m.xz * m.xz + m.yy * m.zz - m.yz * m.yz;
  const double det = m.xx * (m.yy * m.zz - m.yz * m.yz) - m.xy * (m.xy * m.zz - m.yz * m.xz) +
                     m.xz * (m.xy * m.yz - m.yy * m.xz);
  double root = 0;
  for (int step = 0; step < 24; ++step) {
    const double value = ((root - 1) * root + minors) * root - det;
    const double slope = (3 * root - 2) * root + minors;
    if (!(slope > 0)) break;
    const double next = root - value / slope;
    if (!(next > root + 1e-12)) break;
    root = next;
  }
  return std::clamp(root, 0.0, 1.0 / 3.0);
}

/// A unit vector across all rows of m - root: the eigenvector. Zero when m is.
Vector across(const Symmetric3& m, double root) noexcept {
  const Vector rows[3] = {
      {m.xx - root, m.xy, m.xz}, {m.xy, m.yy - root, m.yz}, {m.xz, m.yz, m.zz - root}};
  Vector best;
  for (int i = 0; i < 3; ++i) {
    const Vector v = cross(rows[i], rows[(i + 1) % 3]);
    if (v.square() > best.square()) best = v;
  }
  if (best.square() < 1e-18) {  // a line: the least eigenvalue is a double one
    Vector row = rows[0];
    for (const Vector& r : rows) row = r.square() > row.square() ? r : row;
    const double ax = std::abs(row.x), ay = std::abs(row.y), az = std::abs(row.z);
    const Vector axis =
        ax <= ay && ax <= az ? Vector{1, 0, 0} : (ay <= az ? Vector{0, 1, 0} : Vector{0, 0, 1});
    best = cross(row, axis);
  }
  const double length = std::sqrt(best.square());
  if (!(length > 0)) return {};
  return {best.x / length, best.y / length, best.z / length};
}

}  // namespace

bool least_eigen(const Symmetric3& matrix, LeastEigen& least) noexcept {
  const double trace = matrix.xx + matrix.yy + matrix.zz;
  if (!(trace > 0) || !std::isfinite(trace)) return false;
  const double s = 1 / trace;
  if (!std::isfinite(s)) return false;
  const Symmetric3 m = {matrix.xx * s, matrix.xy * s, matrix.xz * s,
                        matrix.yy * s, matrix.yz * s, matrix.zz * s};
  const double root = least_eigenvalue(m);
  const Vector v = across(m, root);
  if (!(v.square() > 0)) return false;
  least = {v.x, v.y, v.z, root};
  return true;
}

}  // namespace planecast
