// A scene from one pose: solids in the camera's frame, ray casting, and the true surfaces.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/cloud/sensor_frame.hpp"
#include "core/sim/sim_scene.hpp"

namespace planecast {

/// A true surface in the current camera frame (optical axes, metres).
struct TruthSurface {
  enum class Kind : std::uint8_t { kPlane = 0, kSphere = 1, kCylinder = 2 };

  Kind kind = Kind::kPlane;
  Vec3 normal;  ///< plane: normal . p = distance, unit length, distance >= 0
  double distance = 0;
  Vec3 centre;        ///< sphere: centre; cylinder: a point on the axis
  Vec3 axis;          ///< cylinder: unit direction
  double radius = 0;  ///< sphere, cylinder
};

/// Rays (x, y, 1) with x and y in these ranges.
struct RayRange {
  double min_x = 0, max_x = 0, min_y = 0, max_y = 0;
};

/// What a ray meets first: depth along z [m] (0: nothing) and the surface's id (0: nothing).
struct RayHit {
  double z = 0;
  std::uint16_t surface = 0;
};

class SceneView {
 public:
  /// Places the scene before a camera; keeps no reference to it. Ids start at 1: boxes first (faces
  /// -x, +x, -y, +y, -z, +z in their own axes), then spheres, then cylinders (side, bottom, top).
  void look(const SimScene& scene, const Pose& world_from_optical);

  /// Chooses the solids that rays of this range may meet; valid until the next call of look.
  void select(const RayRange& range);

  /// First surface on the ray (x, y, 1) among the selected solids, in front of the camera. A camera
  /// inside a solid does not see that solid.
  RayHit cast(double x, double y) const noexcept;

  /// True surfaces; the one with id k is at index k - 1.
  std::span<const TruthSurface> surfaces() const noexcept { return surfaces_; }

 private:
  enum class Shape : std::uint8_t { kBox, kRoom, kSphere, kCylinder };

  struct Solid {
    Shape shape = Shape::kBox;
    std::uint16_t first_id = 0;
    Rotation axes;  // own axes in the camera frame
    Vec3 eye;       // the camera in own axes
    Vec3 half;      // box: half sides; sphere: radius in x; cylinder: radius, -, half height
    RayRange seen;  // rays that may meet it
    bool visible = true;
  };

  void add(Shape shape, const Rotation& camera, const Vec3& eye, const Vec3& centre,
           const Rotation& axes, const Vec3& half, const Vec3& extent);
  void add_face(const Solid& solid, const Vec3& own_normal, double offset);
  static RayHit meet_box(const Solid& solid, const Vec3& direction) noexcept;
  static RayHit meet_room(const Solid& solid, const Vec3& direction) noexcept;
  static RayHit meet_sphere(const Solid& solid, const Vec3& direction) noexcept;
  static RayHit meet_cylinder(const Solid& solid, const Vec3& direction) noexcept;

  std::vector<Solid> solids_;
  std::vector<std::uint32_t> selected_;  // into solids_
  std::vector<TruthSurface> surfaces_;
};

}  // namespace planecast
