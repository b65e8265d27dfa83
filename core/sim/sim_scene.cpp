#include "core/sim/sim_scene.hpp"

#include <cmath>

namespace planecast {
namespace {

constexpr double kPi = 3.14159265358979323846;

// A box by its lower corner and side lengths, as one would measure it in a room.
SimBox block(double x, double y, double z, double dx, double dy, double dz) {
  SimBox box;
  box.half = {dx / 2, dy / 2, dz / 2};
  box.centre = Vec3{x, y, z} + box.half;
  return box;
}

SimBox turned(SimBox box, double yaw, double pitch, double roll) {
  box.axes = rotation_of(turned_by(yaw, pitch, roll));
  return box;
}

void add_legs(SimScene& scene, double x, double y, double dx, double dy, double height,
              double thick) {
  for (const double px : {x, x + dx - thick}) {
    for (const double py : {y, y + dy - thick}) {
      scene.boxes.push_back(block(px, py, 0, thick, thick, height));
    }
  }
}

void add_table(SimScene& scene) {
  scene.boxes.push_back(block(2.2, 3.9, 0.71, 1.5, 0.75, 0.03));
  add_legs(scene, 2.2, 3.9, 1.5, 0.75, 0.71, 0.06);
  scene.boxes.push_back(turned(block(2.45, 4.15, 0.74, 0.30, 0.20, 0.15), 0.4, 0, 0));
  scene.boxes.push_back(block(3.1, 4.3, 0.74, 0.35, 0.25, 0.02));
  scene.spheres.push_back({{2.95, 4.1, 0.86}, 0.12});
}

void add_chair(SimScene& scene, double x, double y, double back_y) {
  scene.boxes.push_back(block(x, y, 0.43, 0.42, 0.42, 0.04));
  scene.boxes.push_back(block(x, back_y, 0.47, 0.42, 0.03, 0.45));
  add_legs(scene, x, y, 0.42, 0.42, 0.43, 0.04);
}

void add_stairs(SimScene& scene) {
  constexpr double kRise = 0.17;
  constexpr double kRun = 0.29;
  for (int step = 0; step < 4; ++step) {
    const double x = 4.84 + step * kRun;
    scene.boxes.push_back(block(x, 1.6, 0, 6.0 - x, 1.4, (step + 1) * kRise));
  }
}

void add_shelf(SimScene& scene) {
  for (const double z : {0.4, 0.8, 1.2, 1.6}) {
    scene.boxes.push_back(block(4.1, 4.7, z, 1.0, 0.3, 0.025));
  }
  scene.boxes.push_back(block(4.075, 4.7, 0, 0.025, 0.3, 1.8));
  scene.boxes.push_back(block(5.1, 4.7, 0, 0.025, 0.3, 1.8));
  scene.boxes.push_back(block(4.3, 4.75, 0.825, 0.2, 0.2, 0.26));
}

}  // namespace

SimScene room_scene() {
  SimScene scene;
  SimBox room = block(0, 0, 0, 6, 5, 2.6);
  room.inside_out = true;
  scene.boxes.push_back(room);
  add_stairs(scene);
  add_table(scene);
  add_chair(scene, 2.3, 3.55, 3.55);
  add_chair(scene, 3.1, 3.60, 3.60);
  add_shelf(scene);
  scene.boxes.push_back(block(0, 0.5, 0, 0.5, 1.1, 1.9));                           // cabinet
  scene.boxes.push_back(block(0, 2.2, 1.0, 0.03, 0.8, 0.6));                        // picture
  scene.boxes.push_back(turned(block(2.0, 0.3, 0.0, 1.2, 0.03, 1.7), 0, 0, 0.25));  // board
  scene.boxes.push_back(turned(block(3.9, 0.4, 0.0, 0.5, 0.4, 0.35), 0.5, 0, 0));   // carton
  scene.boxes.push_back(turned(block(5.3, 3.7, 0.0, 0.45, 0.45, 0.45), 0.3, 0, 0));
  scene.spheres.push_back({{1.1, 4.2, 0.28}, 0.28});
  scene.cylinders.push_back({{0.55, 3.3, 1.3}, 0.15, 1.3, {}});   // pillar
  scene.cylinders.push_back({{5.0, 0.8, 0.25}, 0.20, 0.25, {}});  // bin
  scene.path.centre = {3.0, 2.4, 1.25};
  scene.path.radius_x = 0.9;
  scene.path.radius_y = 0.6;
  scene.path.period_s = 24;
  scene.path.yaw = 0.35;
  scene.path.yaw_rate = 2 * kPi / 40;
  scene.path.pitch = 0.24;
  scene.path.pitch_swing = 0.16;
  return scene;
}

SimScene curved_scene() {
  SimScene scene;
  SimBox hall = block(0, 0, 0, 8, 7, 3);
  hall.inside_out = true;
  scene.boxes.push_back(hall);
  const Rotation upright;
  const Rotation lying = rotation_of(turned_by(0.4, kPi / 2, 0));
  scene.cylinders.push_back({{9.6, 3.5, 1.5}, 3.0, 1.5, upright});   // the bulging wall
  scene.cylinders.push_back({{4.0, 9.0, 1.5}, 3.2, 1.5, upright});   // and another
  scene.cylinders.push_back({{1.2, 1.2, 1.5}, 0.45, 1.5, upright});  // pillars
  scene.cylinders.push_back({{6.2, 1.1, 1.5}, 0.35, 1.5, upright});
  scene.cylinders.push_back({{1.3, 5.6, 1.5}, 0.60, 1.5, upright});
  scene.cylinders.push_back({{4.0, 0.9, 0.55}, 0.55, 1.1, lying});  // tanks
  scene.cylinders.push_back({{1.2, 3.4, 0.50}, 0.50, 0.8, lying});
  scene.spheres.push_back({{5.8, 5.6, 0.65}, 0.65});
  scene.spheres.push_back({{2.6, 5.4, 0.40}, 0.40});
  scene.spheres.push_back({{6.4, 2.3, 0.50}, 0.50});
  scene.path.centre = {3.9, 3.3, 1.35};
  scene.path.radius_x = 0.8;
  scene.path.radius_y = 0.7;
  scene.path.period_s = 24;
  scene.path.yaw = 0.2;
  scene.path.yaw_rate = 2 * kPi / 40;
  scene.path.pitch = 0.16;
  scene.path.pitch_swing = 0.1;
  return scene;
}

Pose camera_pose(const SimPath& path, double t_s) noexcept {
  // Optical axes (x right, y down, z forward) in a body that looks along x with z up.
  constexpr Pose kBodyFromOptical{0.5, -0.5, 0.5, -0.5, 0, 0, 0};
  const double phase = path.period_s > 0 ? 2 * kPi * t_s / path.period_s : 0;
  const double pitch = path.pitch + path.pitch_swing * std::sin(1.7 * phase);
  const double yaw = path.yaw + path.yaw_rate * (path.period_s > 0 ? t_s : 0);
  Pose pose = combine(turned_by(yaw, pitch, path.roll), kBodyFromOptical);
  pose.tx = path.centre.x + path.radius_x * std::cos(phase);
  pose.ty = path.centre.y + path.radius_y * std::sin(phase);
  // A walker's head bobs by a centimetre or so, eleven times a round.
  const double bob = path.period_s > 0 ? 0.012 * std::sin(11 * phase) : 0;
  pose.tz = path.centre.z + bob;
  return pose;
}

}  // namespace planecast
