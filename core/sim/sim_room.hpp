// The simulator behind `sim:room`: casts the sensor's own rays into a scene and adds the sensor's
// noise, so that a fresh machine has a camera, and tests have the truth. Seeded; all arithmetic is
// double, so the same frames come out on the same machine, not promised to the bit across machines.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/status.hpp"
#include "core/cloud/sensor_frame.hpp"
#include "core/sensor/camera.hpp"
#include "core/sensor/ray_table.hpp"
#include "core/sensor/sensor_preset.hpp"
#include "core/sim/depth_noise.hpp"
#include "core/sim/scene_view.hpp"
#include "core/sim/sim_scene.hpp"

namespace planecast {

/// The simulated sensor.
struct SimConfig {
  std::uint64_t seed = 1;
  Intrinsics intrinsics;
  std::uint32_t width = 640, height = 480;  ///< [px]
  NoiseModel noise;                         ///< unknown = no noise
  double correlated_share = 0.5;            ///< of the noise's variance, shared over about 8 pixels
  double dropout = 0.005;                   ///< share of pixels without a reading
  double baseline_m = 0;                    ///< stereo and structured light; 0 = time of flight
  double steps_per_pixel = 0;               ///< sub-pixel steps of the disparity; 0 = no lattice
  bool shadows = true;                      ///< holes beside near objects, when baseline_m > 0
  double min_m = 0.1, max_m = 20;           ///< readings outside are holes
  double rate_hz = 30;
  bool moving = true;
};

/// The sensor of a preset, e.g. sim_config(*find_preset("azure-nfov")).
SimConfig sim_config(const SensorPreset& preset);

/// The default of `sim:room`: like a RealSense D435 at 640 x 480, stereo:0.003.
SimConfig default_sim_config();

/// Renders depth frames of a scene. Single-threaded, owns all it needs; 20 to 50 ms for 640 x 480.
class RoomSimulator {
 public:
  /// Checks the sensor and builds its rays. Errors: kBadConfig with the number and the mend
  /// (camera, rate, shares outside 0..1, a distortion that cannot be undone, over 65,535 surfaces).
  static Result<RoomSimulator> create(const SimConfig& config, SimScene scene = room_scene());

  /// Renders frame `frame` (any order; the result depends on config, scene and number only).
  /// `depth`: width x height counts, 0 = no reading. `truth_surface_ids`: the surface each pixel's
  /// ray meets (also where the reading was lost), 0 = nothing, else index + 1 into surfaces().
  /// `pose`: world from optical axes. The vectors are resized on first use only.
  void render(std::uint64_t frame, DepthImage& depth, std::vector<std::uint16_t>& truth_surface_ids,
              Pose& pose);

  /// True surfaces of the last rendered frame, in its camera frame; valid until the next render.
  std::span<const TruthSurface> surfaces() const noexcept { return view_.surfaces(); }

  /// True depth of the last rendered frame [m], before noise; 0 = nothing there.
  std::span<const double> true_depth_m() const noexcept { return true_z_m_; }

  const SimConfig& config() const noexcept { return config_; }
  const CameraModel& camera() const noexcept { return camera_; }

 private:
  RoomSimulator(const SimConfig& config, SimScene scene, const CameraModel& camera);
  RayRange tile_range(std::uint32_t u0, std::uint32_t v0, std::uint32_t u1,
                      std::uint32_t v1) const noexcept;
  void cast_tile(std::uint32_t u0, std::uint32_t v0, std::vector<std::uint16_t>& ids);

  SimConfig config_;
  SimScene scene_;
  CameraModel camera_;
  std::vector<double> ray_x_, ray_y_;  // one per pixel
  std::vector<double> true_z_m_;
  SceneView view_;
  DepthNoise noise_;
};

}  // namespace planecast
