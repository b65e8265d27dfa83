#include "core/sim/sim_room.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "core/sim/sim_error.hpp"
#include "core/sim/sim_seed.hpp"

namespace planecast {
namespace {

constexpr std::uint32_t kTile = 16;  // pixels on a side that share one choice of solids

DepthNoiseConfig noise_config(const SimConfig& config) {
  DepthNoiseConfig out;
  out.noise = config.noise;
  out.correlated_share = config.correlated_share;
  out.dropout = config.dropout;
  const double focal_baseline = config.intrinsics.fx * config.baseline_m;
  out.lattice_c_m = focal_baseline * config.steps_per_pixel;
  out.shadow_px_m = config.shadows ? focal_baseline : 0;
  out.metres_per_unit = config.intrinsics.metres_per_unit;
  out.min_m = config.min_m;
  out.max_m = config.max_m;
  return out;
}

bool within(double value, double low, double high) {
  return value >= low && value <= high;
}

}  // namespace

SimConfig sim_config(const SensorPreset& preset) {
  SimConfig config;
  config.intrinsics = preset.intrinsics;
  config.width = preset.width;
  config.height = preset.height;
  config.noise = preset.noise;
  config.baseline_m = preset.baseline_m;
  config.steps_per_pixel = preset.steps_per_pixel;
  config.min_m = preset.min_m;
  config.max_m = preset.max_m;
  config.rate_hz = preset.rate_hz;
  return config;
}

SimConfig default_sim_config() {
  return sim_config(*find_preset("realsense-d435"));
}

Result<RoomSimulator> RoomSimulator::create(const SimConfig& config, SimScene scene) {
  auto camera = quantise(config.intrinsics, config.width, config.height);
  if (!camera) return camera.error();
  if (!within(config.rate_hz, 0.01, 10000)) {
    return bad_value("rate", config.rate_hz, "frames a second, 0.01 to 10000");
  }
  if (!within(config.dropout, 0, 1)) return bad_value("dropout", config.dropout, "a share, 0 to 1");
  if (!within(config.correlated_share, 0, 1)) {
    return bad_value("correlated share", config.correlated_share, "a share, 0 to 1");
  }
  if (!within(config.baseline_m, 0, 100))
    return bad_value("baseline", config.baseline_m, "0 to 100 m");
  if (!within(config.steps_per_pixel, 0, 65536)) {
    return bad_value("steps per pixel", config.steps_per_pixel, "0 to 65536");
  }
  if (scene.surface_count() > 65535) {
    return bad_value("surfaces", static_cast<double>(scene.surface_count()), "at most 65535");
  }
  RoomSimulator simulator(config, std::move(scene), *camera);
  std::vector<std::int32_t> storage(ray_table_entries(*camera));
  RayTable rays;
  if (build_ray_table(*camera, storage, rays) != Status::kOk) {
    return bad_value("k1", config.intrinsics.k1,
                     "this distortion cannot be undone at every pixel; give smaller coefficients");
  }
  std::size_t i = 0;
  for (std::uint32_t v = 0; v < config.height; ++v) {
    for (std::uint32_t u = 0; u < config.width; ++u, ++i) {
      simulator.ray_x_[i] = rays.x(u, v) * 0x1p-27;
      simulator.ray_y_[i] = rays.y(u, v) * 0x1p-27;
    }
  }
  return simulator;
}

RoomSimulator::RoomSimulator(const SimConfig& config, SimScene scene, const CameraModel& camera)
    : config_(config),
      scene_(std::move(scene)),
      camera_(camera),
      ray_x_(camera.pixels()),
      ray_y_(camera.pixels()),
      true_z_m_(camera.pixels()),
      noise_(noise_config(config), config.width, config.height) {}

RayRange RoomSimulator::tile_range(std::uint32_t u0, std::uint32_t v0, std::uint32_t u1,
                                   std::uint32_t v1) const noexcept {
  RayRange range{1e30, -1e30, 1e30, -1e30};
  for (std::uint32_t v = v0; v < v1; ++v) {
    for (std::uint32_t u = u0; u < u1; ++u) {
      const std::size_t i = std::size_t{v} * config_.width + u;
      range.min_x = std::min(range.min_x, ray_x_[i]);
      range.max_x = std::max(range.max_x, ray_x_[i]);
      range.min_y = std::min(range.min_y, ray_y_[i]);
      range.max_y = std::max(range.max_y, ray_y_[i]);
    }
  }
  return range;
}

void RoomSimulator::cast_tile(std::uint32_t u0, std::uint32_t v0, std::vector<std::uint16_t>& ids) {
  const std::uint32_t u1 = std::min(u0 + kTile, config_.width);
  const std::uint32_t v1 = std::min(v0 + kTile, config_.height);
  view_.select(tile_range(u0, v0, u1, v1));
  for (std::uint32_t v = v0; v < v1; ++v) {
    for (std::uint32_t u = u0; u < u1; ++u) {
      const std::size_t i = std::size_t{v} * config_.width + u;
      const RayHit hit = view_.cast(ray_x_[i], ray_y_[i]);
      true_z_m_[i] = hit.z;
      ids[i] = hit.surface;
    }
  }
}

void RoomSimulator::render(std::uint64_t frame, DepthImage& depth,
                           std::vector<std::uint16_t>& truth_surface_ids, Pose& pose) {
  depth.width = config_.width;
  depth.height = config_.height;
  depth.depth.resize(camera_.pixels());
  truth_surface_ids.resize(camera_.pixels());
  const double time_s = config_.moving ? static_cast<double>(frame) / config_.rate_hz : 0;
  pose = camera_pose(scene_.path, time_s);
  view_.look(scene_, pose);
  for (std::uint32_t v = 0; v < config_.height; v += kTile) {
    for (std::uint32_t u = 0; u < config_.width; u += kTile) cast_tile(u, v, truth_surface_ids);
  }
  Pcg32 random(frame_seed(config_.seed, frame));
  noise_.apply(true_z_m_, random, depth.depth);
}

}  // namespace planecast
