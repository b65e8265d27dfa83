// The direction in which a set of points spreads least: the normal of its plane. Encoder half.
#pragma once

namespace planecast {

/// A symmetric 3 x 3 matrix, positive semidefinite: a covariance.
struct Symmetric3 {
  double xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
};

/// The eigenvector of the least eigenvalue, of unit length, and that eigenvalue's share of their
/// sum, 0..1/3.
struct LeastEigen {
  double x = 0, y = 0, z = 1;
  double share = 0;
};

/// False, with nothing written, when the matrix is zero or not finite. Of a double least eigenvalue
/// (points on a line) any of its vectors is given. About 60 ns.
bool least_eigen(const Symmetric3& matrix, LeastEigen& least) noexcept;

}  // namespace planecast
