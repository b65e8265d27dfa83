// What the simulator looks at: solids with places in a world of metres, z up, and the path that the
// camera walks. Scenes are data; casting rays into them is scene_view.hpp.
#pragma once

#include <cstdint>
#include <vector>

#include "core/cloud/sensor_frame.hpp"
#include "core/sim/sim_math.hpp"

namespace planecast {

/// A box seen from outside or, for a room, from inside.
struct SimBox {
  Vec3 centre;  ///< [m], world
  Vec3 half;    ///< half side lengths [m], in its own axes
  Rotation axes;
  bool inside_out = false;  ///< only the far faces are seen: walls, floor and ceiling
};

struct SimSphere {
  Vec3 centre;  ///< [m], world
  double radius = 0;
};

/// A solid cylinder with flat ends.
struct SimCylinder {
  Vec3 centre;  ///< [m], world
  double radius = 0, half_height = 0;
  Rotation axes;  ///< the cylinder's axis is axes.z
};

/// The camera's walk: an ellipse at eye height with a slow pan. At rest when period_s is 0.
struct SimPath {
  Vec3 centre{0, 0, 1.25};
  double radius_x = 0, radius_y = 0;            ///< [m]
  double period_s = 0;                          ///< of one round
  double yaw = 0, yaw_rate = 0;                 ///< [rad], [rad/s]; yaw 0 looks along +x
  double pitch = 0, pitch_swing = 0, roll = 0;  ///< [rad]; positive pitch looks down
};

struct SimScene {
  std::vector<SimBox> boxes;
  std::vector<SimSphere> spheres;
  std::vector<SimCylinder> cylinders;
  SimPath path;

  /// Surfaces of all solids: 6 a box, 1 a sphere, 3 a cylinder.
  std::size_t surface_count() const noexcept {
    return 6 * boxes.size() + spheres.size() + 3 * cylinders.size();
  }
};

/// `sim:room`: a furnished room of 6 x 5 x 2.6 m with four stairs, table, chairs, cabinet, shelf, a
/// leaning board, boxes, two spheres and two cylinders; the camera walks in the free middle.
SimScene room_scene();

/// `sim:curved`: a hall of 8 x 7 x 3 m with little in it that is flat but floor, ceiling and walls:
/// a wall that bulges, pillars, tanks and spheres, close to the camera's round.
SimScene curved_scene();

/// World pose of the camera (optical axes) at a time; smooth in t_s [s].
Pose camera_pose(const SimPath& path, double t_s) noexcept;

}  // namespace planecast
