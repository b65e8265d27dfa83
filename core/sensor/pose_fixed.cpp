#include "core/sensor/pose_fixed.hpp"

#include "core/sensor/ray_length.hpp"

namespace planecast {
namespace {

constexpr double kOneQ30 = 1073741824.0;
constexpr double kMicrometresPerMetre = 1e6;

using Quaternion = std::array<std::int64_t, 4>;

// Also false for NaN; excludes infinity.
bool finite(double value) noexcept {
  return value - value == 0.0;
}

std::int64_t round_half_away(double value) noexcept {
  return static_cast<std::int64_t>(value < 0 ? value - 0.5 : value + 0.5);
}

std::uint64_t norm_squared(const Quaternion& q) noexcept {
  std::uint64_t sum = 0;
  for (const std::int64_t c : q) sum += static_cast<std::uint64_t>(c * c);
  return sum;
}

bool first_is_positive(const Quaternion& q) noexcept {
  for (const std::int64_t c : q) {
    if (c != 0) return c > 0;
  }
  return false;
}

// Scales a Q30 quaternion to unit norm, by integers. |components| <= 2^30, not all 0.
void normalise(Quaternion& q) noexcept {
  const auto norm = static_cast<std::int64_t>(sqrt_ceil(norm_squared(q)));
  for (std::int64_t& c : q) {
    const std::int64_t magnitude = ((c < 0 ? -c : c) * (std::int64_t{1} << 30U) + norm / 2) / norm;
    c = c < 0 ? -magnitude : magnitude;
  }
}

bool unit_norm(const Quaternion& q) noexcept {
  constexpr std::uint64_t kOneQ60 = std::uint64_t{1} << 60U;
  constexpr std::uint64_t kSlack = std::uint64_t{1} << 33U;  // 2^-28 of the norm
  const std::uint64_t square = norm_squared(q);
  return square >= kOneQ60 - kSlack && square <= kOneQ60 + kSlack;
}

}  // namespace

Status to_fixed(const Pose& pose, PoseFixed& out) noexcept {
  const double in[4] = {pose.qw, pose.qx, pose.qy, pose.qz};
  double largest = 0;
  for (const double c : in) {
    if (!finite(c)) return Status::kFieldRange;
    largest = (c < 0 ? -c : c) > largest ? (c < 0 ? -c : c) : largest;
  }
  if (largest == 0) return Status::kFieldRange;
  PoseFixed fixed;
  const double t[3] = {pose.tx, pose.ty, pose.tz};
  for (std::size_t i = 0; i < 3; ++i) {
    const double um = t[i] * kMicrometresPerMetre;
    const auto limit = static_cast<double>(kMaxTranslationUm);
    if (!(um >= -limit && um <= limit)) return Status::kFieldRange;
    fixed.t_um[i] = round_half_away(um);
  }
  // A pose that is canonical already stays as it is, so that it survives any number of hops.
  Quaternion q{};
  for (std::size_t i = 0; i < 4; ++i) {
    if (largest <= 1.0) q[i] = round_half_away(in[i] * kOneQ30);
  }
  if (!unit_norm(q)) {
    for (std::size_t i = 0; i < 4; ++i) q[i] = round_half_away(in[i] / largest * kOneQ30);
    normalise(q);
  }
  const int sign = first_is_positive(q) ? 1 : -1;
  for (std::size_t i = 0; i < 4; ++i) fixed.q_q30[i] = static_cast<std::int32_t>(sign * q[i]);
  out = fixed;
  return Status::kOk;
}

Status check_pose(const PoseFixed& pose) noexcept {
  constexpr std::int64_t kOne = std::int64_t{1} << 30U;
  Quaternion q{};
  for (std::size_t i = 0; i < 4; ++i) {
    q[i] = pose.q_q30[i];
    if (q[i] > kOne || q[i] < -kOne) return Status::kFieldRange;
  }
  if (!unit_norm(q) || !first_is_positive(q)) return Status::kFieldRange;
  for (const std::int64_t t : pose.t_um) {
    if (t > kMaxTranslationUm || t < -kMaxTranslationUm) return Status::kFieldRange;
  }
  return Status::kOk;
}

Pose to_pose(const PoseFixed& pose) noexcept {
  Pose out;
  out.qw = pose.q_q30[0] / kOneQ30;
  out.qx = pose.q_q30[1] / kOneQ30;
  out.qy = pose.q_q30[2] / kOneQ30;
  out.qz = pose.q_q30[3] / kOneQ30;
  out.tx = static_cast<double>(pose.t_um[0]) / kMicrometresPerMetre;
  out.ty = static_cast<double>(pose.t_um[1]) / kMicrometresPerMetre;
  out.tz = static_cast<double>(pose.t_um[2]) / kMicrometresPerMetre;
  return out;
}

}  // namespace planecast
