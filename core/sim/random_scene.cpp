#include "core/sim/random_scene.hpp"

#include <algorithm>
#include <vector>

#include "core/base/random.hpp"

namespace planecast {
namespace {

double between(Pcg32& random, double low, double high) {
  return low + (high - low) * random.uniform();
}

bool chance(Pcg32& random, double share) {
  return random.uniform() < share;
}

// Named one by one: the order in which arguments are evaluated differs between compilers.
Rotation any_rotation(Pcg32& random) {
  const double yaw = between(random, -3.1, 3.1);
  const double pitch = between(random, -1.5, 1.5);
  const double roll = between(random, -3.1, 3.1);
  return rotation_of(turned_by(yaw, pitch, roll));
}

Vec3 any_place(Pcg32& random, double reach) {
  return {between(random, -reach, reach), between(random, -reach, reach), between(random, 0, 3)};
}

std::uint32_t any_side(Pcg32& random, std::uint32_t largest) {
  constexpr std::uint32_t kEdgeCases[] = {1, 2, 3, 7, 8, 9, 15, 16, 17, 31, 32, 33, 63, 64, 65};
  switch (random.below(4)) {
    case 0:
      return kEdgeCases[random.below(15)];
    case 1:
      return 1 + random.below(64);
    case 2:
      return 1 + random.below(largest / 2);
    default:
      return 1 + random.below(largest);
  }
}

void any_noise(Pcg32& random, SimConfig& config) {
  const std::uint32_t kind = random.below(5);
  if (kind <= 1) {
    config.noise = {NoiseModel::Kind::kStereo, 100'000 + random.below(10'000'000)};
    config.baseline_m = between(random, 0.03, 0.2);
    if (kind == 0) config.steps_per_pixel = 1 << random.below(6);
  } else if (kind <= 3) {
    config.noise = {NoiseModel::Kind::kTof, 100'000 + random.below(30'000'000)};
  }
  config.correlated_share = chance(random, 0.5) ? random.uniform() : 0;
  config.dropout = chance(random, 0.7) ? 0.005 : random.uniform();
  config.shadows = chance(random, 0.5);
}

// Lenses that fold or look too far off axis are drawn again, weaker each time.
void any_camera(Pcg32& random, SimConfig& config) {
  constexpr double kUnits[] = {0.001, 0.001, 0.001, 0.0001, 0.00025, 0.01};
  Intrinsics& in = config.intrinsics;
  const double size = std::max(config.width, config.height);
  in.fx = size * between(random, 0.4, 2.0);
  in.fy = in.fx * between(random, 0.9, 1.1);
  in.cx = config.width * between(random, 0.2, 0.8);
  in.cy = config.height * between(random, 0.2, 0.8);
  in.metres_per_unit = kUnits[random.below(6)];
  if (chance(random, 0.6)) return;
  for (double strength = 0.3; strength > 0.001; strength *= 0.5) {
    in.k1 = between(random, -strength, strength);
    in.k2 = between(random, -strength, strength) / 3;
    in.k3 = between(random, -strength, strength) / 10;
    in.p1 = between(random, -strength, strength) / 50;
    in.p2 = between(random, -strength, strength) / 50;
    const auto camera = quantise(in, config.width, config.height);
    if (!camera) continue;
    std::vector<std::int32_t> storage(ray_table_entries(*camera));
    RayTable rays;
    if (build_ray_table(*camera, storage, rays) == Status::kOk) return;
  }
  in.k1 = in.k2 = in.k3 = in.p1 = in.p2 = 0;
}

void any_path(Pcg32& random, SimPath& path) {
  path.centre = {between(random, -0.5, 0.5), between(random, -0.5, 0.5), between(random, 0.3, 2)};
  path.yaw = between(random, -3.1, 3.1);
  path.pitch = between(random, -1.2, 1.2);
  path.roll = between(random, -0.5, 0.5);
  if (chance(random, 0.5)) return;
  path.radius_x = between(random, 0, 0.5);
  path.radius_y = between(random, 0, 0.5);
  path.period_s = between(random, 5, 30);
  path.yaw_rate = between(random, -0.5, 0.5);
}

}  // namespace

RandomScene random_scene(std::uint64_t seed) {
  Pcg32 random(seed, 77);
  RandomScene out;
  out.config.seed = seed;
  out.config.width = any_side(random, 640);
  out.config.height = any_side(random, 480);
  out.config.min_m = 0.05;
  out.config.max_m = chance(random, 0.8) ? 60 : between(random, 1, 5);
  any_noise(random, out.config);
  any_camera(random, out.config);
  any_path(random, out.scene.path);
  const double reach = between(random, 1, 8);
  if (chance(random, 0.8)) {
    SimBox room;
    room.half = {reach, reach, between(random, 1.2, 3)};
    room.centre = {0, 0, room.half.z};
    if (chance(random, 0.3)) room.axes = any_rotation(random);
    room.inside_out = true;
    out.scene.boxes.push_back(room);
  }
  for (std::uint32_t i = random.below(20); i > 0; --i) {
    SimBox box;
    box.centre = any_place(random, reach);
    box.half = {between(random, 0.01, 0.6), between(random, 0.01, 0.6), between(random, 0.01, 0.6)};
    if (chance(random, 0.6)) box.axes = any_rotation(random);
    out.scene.boxes.push_back(box);
  }
  for (std::uint32_t i = random.below(4); i > 0; --i) {
    out.scene.spheres.push_back({any_place(random, reach), between(random, 0.02, 0.8)});
  }
  for (std::uint32_t i = random.below(4); i > 0; --i) {
    out.scene.cylinders.push_back({any_place(random, reach), between(random, 0.02, 0.4),
                                   between(random, 0.05, 1.0), any_rotation(random)});
  }
  return out;
}

}  // namespace planecast
