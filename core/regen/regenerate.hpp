// The last step of decoding: every reading goes along its ray to its depth. IEEE double + - * /
// with contraction off, one cut to float32: the same points on every machine.
#pragma once

#include <cstdint>
#include <span>

#include "core/base/arena.hpp"
#include "core/base/lanes.hpp"
#include "core/base/status.hpp"
#include "core/base/work_team.hpp"
#include "core/cloud/sensor_frame.hpp"
#include "core/model/stream_config.hpp"
#include "core/sensor/ray_table.hpp"

namespace planecast {

/// z [m] of every depth count of a stream, as the input's own float rule gives it. 256 KiB.
class DepthScale {
 public:
  void layout(Arena& arena) noexcept { z_ = arena.take<float>(65536); }
  /// Fills the table for a stream: O(65536).
  void build(const StreamConfig& config) noexcept;
  float z(std::uint16_t count) const noexcept { return z_[count]; }
  /// of four counts
  Float4 z4(const std::uint16_t* counts) const noexcept {
    const float* const z = z_.data();
    return Float4{z[counts[0]], z[counts[1]], z[counts[2]], z[counts[3]]};
  }

 private:
  std::span<float> z_;
};

/// Regenerates the cloud of a depth image: out[i] belongs to pixel i (row-major, width * height of
/// the camera), in metres, in the cloud's own axes (config.axes; optical axes unless they were
/// estimated); holes are NaN. No allocation; about 1 ns a pixel, by `team` in bands of rows.
/// kWrongSize: a span is too short.
Status regenerate(const StreamConfig& config, const RayTable& rays, const DepthScale& scale,
                  std::span<const std::uint16_t> depth, std::span<Point3f> out,
                  const WorkTeam& team = {}) noexcept;

}  // namespace planecast
