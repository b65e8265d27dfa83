// Three-vectors and rotations in double, just what the simulator needs.
#pragma once

#include <cmath>

#include "core/cloud/sensor_frame.hpp"

namespace planecast {

struct Vec3 {
  double x = 0, y = 0, z = 0;
};

inline Vec3 operator+(const Vec3& a, const Vec3& b) noexcept {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline Vec3 operator-(const Vec3& a, const Vec3& b) noexcept {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Vec3 operator*(double s, const Vec3& a) noexcept {
  return {s * a.x, s * a.y, s * a.z};
}
inline double dot(const Vec3& a, const Vec3& b) noexcept {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

/// A rotation as its three columns: the axes of the turned frame.
struct Rotation {
  Vec3 x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};

  Vec3 apply(const Vec3& p) const noexcept { return p.x * x + p.y * y + p.z * z; }
  Vec3 undo(const Vec3& p) const noexcept { return {dot(x, p), dot(y, p), dot(z, p)}; }
};

/// Rotation of a unit quaternion.
inline Rotation rotation_of(const Pose& q) noexcept {
  const double w = q.qw, x = q.qx, y = q.qy, z = q.qz;
  return {{1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)},
          {2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)},
          {2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)}};
}

/// Rotation by yaw about z, then pitch about the turned y, then roll about the turned x [rad], as a
/// pose without translation.
inline Pose turned_by(double yaw, double pitch, double roll) noexcept {
  const double cy = std::cos(yaw / 2), sy = std::sin(yaw / 2);
  const double cp = std::cos(pitch / 2), sp = std::sin(pitch / 2);
  const double cr = std::cos(roll / 2), sr = std::sin(roll / 2);
  return {cy * cp * cr + sy * sp * sr,
          cy * cp * sr - sy * sp * cr,
          cy * sp * cr + sy * cp * sr,
          sy * cp * cr - cy * sp * sr,
          0,
          0,
          0};
}

/// Product of two rotations given as quaternions: first b, then a. No translation.
inline Pose combine(const Pose& a, const Pose& b) noexcept {
  return {a.qw * b.qw - a.qx * b.qx - a.qy * b.qy - a.qz * b.qz,
          a.qw * b.qx + a.qx * b.qw + a.qy * b.qz - a.qz * b.qy,
          a.qw * b.qy - a.qx * b.qz + a.qy * b.qw + a.qz * b.qx,
          a.qw * b.qz + a.qx * b.qy - a.qy * b.qx + a.qz * b.qw,
          0,
          0,
          0};
}

}  // namespace planecast
