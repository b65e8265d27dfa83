// The simulator behind `sim:scan`: a 2-D laser that turns about the vertical axis scans a scene
// into a list of points without order or grid, as a tilting laser or a mapping rig delivers it.
// Seeded; all arithmetic is double: the same scans on the same machine, not promised to the bit
// across.
#pragma once

#include <cstdint>

#include "core/base/status.hpp"
#include "core/cloud/sensor_frame.hpp"
#include "core/sensor/noise_model.hpp"
#include "core/sim/scene_view.hpp"
#include "core/sim/sim_scene.hpp"

namespace planecast {

/// The simulated scanner.
struct ScanConfig {
  std::uint64_t seed = 1;
  std::uint32_t turns = 720;  ///< positions about the vertical axis, over 360 degrees
  std::uint32_t beams = 160;  ///< of one position, evenly over +-beam_reach_rad of elevation
  double beam_reach_rad = 1.2;
  NoiseModel noise{NoiseModel::Kind::kTof, 4'000'000};  ///< along the beam
  double dropout = 0.02;                                ///< share of beams that return nothing
  double min_m = 0.1, max_m = 30;                       ///< readings outside are none
  double rate_hz = 1;
  bool moving = true;  ///< the rig walks the scene's path from scan to scan
};

/// Scans a scene. Single-threaded, owns all it needs; about 20 ms for 100,000 points.
class ScanSimulator {
 public:
  /// Errors: kBadConfig with the number and the mend (no beams, reach, shares, rate).
  static Result<ScanSimulator> create(const ScanConfig& config, SimScene scene = room_scene());

  /// Scan `frame` (any order): the points [m], relative to the scanner, z up, in the order in which
  /// the beams met them; a beam without an echo leaves no point, so counts differ from scan to
  /// scan. `pose`: world from the scanner's axes.
  void render(std::uint64_t frame, PointCloud& cloud, Pose& pose);

  const ScanConfig& config() const noexcept { return config_; }

 private:
  ScanSimulator(const ScanConfig& config, SimScene scene)
      : config_(config), scene_(std::move(scene)) {}

  ScanConfig config_;
  SimScene scene_;
  SceneView view_;
};

}  // namespace planecast
