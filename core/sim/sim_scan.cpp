#include "core/sim/sim_scan.hpp"

#include <cmath>
#include <numbers>

#include "core/base/random.hpp"
#include "core/sim/sim_error.hpp"
#include "core/sim/sim_math.hpp"
#include "core/sim/sim_seed.hpp"

namespace planecast {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;
// Optical axes (x right, y down, z forward) in axes that look along x with z up.
constexpr Pose kLevelFromOptical{0.5, -0.5, 0.5, -0.5, 0, 0, 0};

// One number of mean 0 and deviation 1 (Box and Muller).
double gauss(Pcg32& random) {
  const double u = 1 - random.uniform(), v = random.uniform();
  return std::sqrt(-2 * std::log(u)) * std::cos(kTurn * v);
}

}  // namespace

Result<ScanSimulator> ScanSimulator::create(const ScanConfig& config, SimScene scene) {
  if (config.turns < 1 || config.turns > 100'000)
    return bad_value("turns", config.turns, "positions of the laser, 1 to 100000");
  if (config.beams < 1 || config.beams > 100'000)
    return bad_value("beams", config.beams, "beams a position, 1 to 100000");
  if (!(config.beam_reach_rad > 0 && config.beam_reach_rad <= 1.4))
    return bad_value("beam reach", config.beam_reach_rad, "elevation either way, up to 1.4 rad");
  if (!(config.dropout >= 0 && config.dropout <= 1))
    return bad_value("dropout", config.dropout, "a share, 0 to 1");
  if (!(config.rate_hz >= 0.01 && config.rate_hz <= 10000))
    return bad_value("rate", config.rate_hz, "scans a second, 0.01 to 10000");
  return ScanSimulator(config, std::move(scene));
}

void ScanSimulator::render(std::uint64_t frame, PointCloud& cloud, Pose& pose) {
  const double time_s = config_.moving ? static_cast<double>(frame) / config_.rate_hz : 0;
  const Pose eye = camera_pose(scene_.path, time_s);
  pose = {1, 0, 0, 0, eye.tx, eye.ty, eye.tz};  // the rig stays level
  Pcg32 random(frame_seed(config_.seed, frame));
  cloud = {};
  const double reach = std::tan(config_.beam_reach_rad);
  for (std::uint32_t turn = 0; turn < config_.turns; ++turn) {
    const double azimuth = kTurn * turn / config_.turns;
    Pose optical = combine(turned_by(azimuth, 0, 0), kLevelFromOptical);
    optical.tx = eye.tx;
    optical.ty = eye.ty;
    optical.tz = eye.tz;
    view_.look(scene_, optical);
    view_.select({-1e-9, 1e-9, -reach, reach});
    for (std::uint32_t beam = 0; beam < config_.beams; ++beam) {
      const double share = (beam + 0.5) / config_.beams;
      const double elevation = config_.beam_reach_rad * (2 * share - 1);
      const double slope = std::tan(elevation);
      const RayHit hit = view_.cast(0, -slope);
      const double stray = gauss(random);
      const bool lost = random.uniform() < config_.dropout;
      if (hit.z <= 0 || lost) continue;
      const double true_m = hit.z * std::sqrt(1 + slope * slope);
      const double range = true_m + config_.noise.sigma_m(true_m) * stray;
      if (!(range >= config_.min_m && range <= config_.max_m)) continue;
      const double level = range * std::cos(elevation);
      cloud.points.push_back({static_cast<float>(level * std::cos(azimuth)),
                              static_cast<float>(level * std::sin(azimuth)),
                              static_cast<float>(range * std::sin(elevation))});
    }
  }
  cloud.width = static_cast<std::uint32_t>(cloud.points.size());
  cloud.height = 1;
}

}  // namespace planecast
