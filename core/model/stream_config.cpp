#include "core/model/stream_config.hpp"

namespace planecast {
namespace {

bool ascii_name(const std::array<char, kMaxFrameIdBytes + 1>& name) noexcept {
  bool ended = false;
  for (const char c : name) {
    if (ended && c != 0) return false;
    if (c == 0) ended = true;
    if (!ended && (c < 0x20 || c > 0x7e)) return false;
  }
  return ended;
}

// Fields of a kPoints stream, and the others at rest: one way to write each configuration.
Status check_points(const StreamConfig& config) noexcept {
  const PointStream& points = config.points;
  const bool in_range = points.max_points >= 1 && points.max_points <= kMaxFramePoints &&
                        points.step_pm <= kMaxPointStepPm &&
                        points.tolerance_steps <= kMaxPointToleranceSteps &&
                        points.patch_unit_nm >= 1 && points.patch_unit_nm <= kMaxPatchUnitNm &&
                        points.fill <= FillMode::kRandom;
  const bool at_rest = config.camera == CameraModel{} && config.lattice == Lattice{} &&
                       config.z_rule == ZRule::kProductInDouble && !config.mirror_y &&
                       config.axes.q_q30 == PoseFixed{}.q_q30;
  if (!in_range || !at_rest) return Status::kFieldRange;
  // A bound needs a grid, and sigma must not depend on where a sensor stands.
  const bool bounded = config.tolerance != ToleranceKind::kLossless;
  const bool in_sigmas = config.tolerance >= ToleranceKind::kSigma;
  if (bounded && points.step_pm == 0) return Status::kFieldRange;
  if (in_sigmas && config.noise.kind != NoiseModel::Kind::kTof) return Status::kFieldRange;
  return points.tolerance_steps * points.step_pm <= point_bound_pm(config) ? Status::kOk
                                                                           : Status::kFieldRange;
}

}  // namespace

std::uint64_t point_bound_pm(const StreamConfig& config) noexcept {
  switch (config.tolerance) {
    case ToleranceKind::kLossless:
      break;
    case ToleranceKind::kMetres:
      return std::uint64_t{config.tolerance_100nm} * 100'000;
    case ToleranceKind::kSigma:
    case ToleranceKind::kSurfaces:
      return ((std::uint64_t{config.sigmas_q16} * config.noise.s_e9) >> 16U) * 1000;
  }
  return 0;
}

Status check_config(const StreamConfig& config) noexcept {
  const bool kinds = config.kind <= FrameKind::kPoints && config.z_rule <= ZRule::kPrinted7 &&
                     config.tolerance <= ToleranceKind::kSurfaces &&
                     config.clock <= ClockDomain::kSensor &&
                     config.noise.kind <= NoiseModel::Kind::kTof;
  if (!kinds || config.period_ms == 0) return Status::kFieldRange;
  if (config.lattice.offset_q16 > 0xffff) return Status::kFieldRange;
  if (config.lattice.present() && config.lattice.c_q8 < kMinLatticeCQ8) return Status::kFieldRange;
  const bool needs_sigma =
      config.tolerance == ToleranceKind::kSigma || config.tolerance == ToleranceKind::kSurfaces;
  if (needs_sigma && config.sigmas_q16 == 0) return Status::kFieldRange;
  if (config.drop_off_surface && config.tolerance != ToleranceKind::kSurfaces) {
    return Status::kFieldRange;
  }
  if (!ascii_name(config.frame_id)) return Status::kFieldRange;
  const bool points = config.kind == FrameKind::kPoints;
  if (!points && config.points != PointStream{}) return Status::kFieldRange;
  const Status sensor = points ? check_points(config) : check_camera(config.camera);
  if (sensor != Status::kOk) return sensor;
  if (const Status status = check_pose(config.pose); status != Status::kOk) return status;
  return check_pose(config.axes);
}

}  // namespace planecast
