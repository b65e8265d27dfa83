// The pose as it travels in the key packet: integers, so that both ends hold the same bits and two
// poses compare exactly.
#pragma once

#include <array>
#include <cstdint>

#include "core/base/status.hpp"
#include "core/cloud/sensor_frame.hpp"

namespace planecast {

/// Sensor pose in fixed point. Canonical: unit norm to 2^-28, first component that is not 0 is
/// positive, |translation| <= kMaxTranslationUm.
struct PoseFixed {
  std::array<std::int32_t, 4> q_q30{1 << 30, 0, 0, 0};  ///< w, x, y, z
  std::array<std::int64_t, 3> t_um{0, 0, 0};            ///< x, y, z [micrometres]

  friend bool operator==(const PoseFixed&, const PoseFixed&) = default;
};

/// 10^9 m: beyond any site, and exact in a double.
inline constexpr std::int64_t kMaxTranslationUm = 1'000'000'000'000'000;

/// Rounds a pose; the quaternion need not be of unit length. Rotation within 4e-9 rad, translation
/// within 0.5 um (plus the double's own spacing). kOk; kFieldRange: a number that is not finite, a
/// zero quaternion or a translation beyond 10^9 m (`out` untouched).
Status to_fixed(const Pose& pose, PoseFixed& out) noexcept;

/// Checks a pose that came from outside: kOk, or kFieldRange when it is not canonical.
Status check_pose(const PoseFixed& pose) noexcept;

/// The doubles a fixed pose stands for, exactly for the quaternion; to_fixed gives the same bits
/// back for every canonical pose that to_fixed made.
Pose to_pose(const PoseFixed& pose) noexcept;

}  // namespace planecast
