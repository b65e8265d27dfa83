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

}  // namespace

Status check_config(const StreamConfig& config) noexcept {
  const bool kinds = config.kind <= FrameKind::kRawCloud && config.z_rule <= ZRule::kPrinted7 &&
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
  if (const Status status = check_camera(config.camera); status != Status::kOk) return status;
  if (const Status status = check_pose(config.pose); status != Status::kOk) return status;
  return check_pose(config.axes);
}

}  // namespace planecast
