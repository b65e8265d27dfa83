#include "core/sim/scene_view.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace planecast {
namespace {

constexpr double kNearest_m = 1e-3;  // nothing closer than this is seen
constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Slab {
  double enter, leave;
};

// Where a ray is between -half and +half on one axis.
Slab cross(double eye, double direction, double half) noexcept {
  if (direction == 0) {
    const bool between = eye >= -half && eye <= half;
    return between ? Slab{-kInfinity, kInfinity} : Slab{kInfinity, -kInfinity};
  }
  const double inverse = 1 / direction;
  const double a = (-half - eye) * inverse;
  const double b = (half - eye) * inverse;
  return a < b ? Slab{a, b} : Slab{b, a};
}

// Rays that may meet a box; everything when the box reaches behind the camera.
RayRange range_of(const Vec3& centre, const Rotation& axes, const Vec3& extent, bool& visible) {
  RayRange range{kInfinity, -kInfinity, kInfinity, -kInfinity};
  int behind = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 own{(corner & 1) != 0 ? extent.x : -extent.x,
                   (corner & 2) != 0 ? extent.y : -extent.y,
                   (corner & 4) != 0 ? extent.z : -extent.z};
    const Vec3 p = centre + axes.apply(own);
    if (p.z < kNearest_m) {
      ++behind;
      continue;
    }
    range.min_x = std::min(range.min_x, p.x / p.z);
    range.max_x = std::max(range.max_x, p.x / p.z);
    range.min_y = std::min(range.min_y, p.y / p.z);
    range.max_y = std::max(range.max_y, p.y / p.z);
  }
  visible = behind < 8;
  if (behind > 0) return {-kInfinity, kInfinity, -kInfinity, kInfinity};
  return range;
}

bool overlap(const RayRange& a, const RayRange& b) noexcept {
  return a.min_x <= b.max_x && b.min_x <= a.max_x && a.min_y <= b.max_y && b.min_y <= a.max_y;
}

}  // namespace

void SceneView::add_face(const Solid& solid, const Vec3& own_normal, double offset) {
  TruthSurface face;
  face.kind = TruthSurface::Kind::kPlane;
  face.normal = solid.axes.apply(own_normal);
  face.distance = offset - dot(own_normal, solid.eye);
  if (face.distance < 0) {
    face.distance = -face.distance;
    face.normal = -1.0 * face.normal;
  }
  surfaces_.push_back(face);
}

void SceneView::add(Shape shape, const Rotation& camera, const Vec3& eye, const Vec3& centre,
                    const Rotation& axes, const Vec3& half, const Vec3& extent) {
  Solid solid;
  solid.shape = shape;
  solid.first_id = static_cast<std::uint16_t>(surfaces_.size() + 1);
  solid.axes = {camera.undo(axes.x), camera.undo(axes.y), camera.undo(axes.z)};
  solid.eye = axes.undo(eye - centre);
  solid.half = half;
  const Vec3 place = camera.undo(centre - eye);
  solid.seen = range_of(place, solid.axes, extent, solid.visible);
  if (shape == Shape::kBox || shape == Shape::kRoom) {
    const Vec3 normals[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    const double sides[3] = {half.x, half.y, half.z};
    for (int axis = 0; axis < 3; ++axis) {
      add_face(solid, normals[axis], -sides[axis]);
      add_face(solid, normals[axis], sides[axis]);
    }
  } else {
    TruthSurface round;
    round.kind =
        shape == Shape::kSphere ? TruthSurface::Kind::kSphere : TruthSurface::Kind::kCylinder;
    round.centre = place;
    round.axis = shape == Shape::kSphere ? Vec3{} : solid.axes.z;
    round.radius = half.x;
    surfaces_.push_back(round);
    if (shape == Shape::kCylinder) {
      add_face(solid, {0, 0, 1}, -half.z);
      add_face(solid, {0, 0, 1}, half.z);
    }
  }
  solids_.push_back(solid);
}

void SceneView::look(const SimScene& scene, const Pose& pose) {
  solids_.clear();
  selected_.clear();
  surfaces_.clear();
  const Rotation camera = rotation_of(pose);
  const Vec3 eye{pose.tx, pose.ty, pose.tz};
  for (const SimBox& box : scene.boxes) {
    add(box.inside_out ? Shape::kRoom : Shape::kBox, camera, eye, box.centre, box.axes, box.half,
        box.half);
  }
  for (const SimSphere& sphere : scene.spheres) {
    const Vec3 extent{sphere.radius, sphere.radius, sphere.radius};
    add(Shape::kSphere, camera, eye, sphere.centre, Rotation{}, extent, extent);
  }
  for (const SimCylinder& cylinder : scene.cylinders) {
    const Vec3 extent{cylinder.radius, cylinder.radius, cylinder.half_height};
    add(Shape::kCylinder, camera, eye, cylinder.centre, cylinder.axes, extent, extent);
  }
}

void SceneView::select(const RayRange& range) {
  selected_.clear();
  for (std::uint32_t i = 0; i < solids_.size(); ++i) {
    if (solids_[i].visible && overlap(solids_[i].seen, range)) selected_.push_back(i);
  }
}

RayHit SceneView::meet_box(const Solid& solid, const Vec3& d) noexcept {
  const double eye[3] = {solid.eye.x, solid.eye.y, solid.eye.z};
  const double direction[3] = {d.x, d.y, d.z};
  const double half[3] = {solid.half.x, solid.half.y, solid.half.z};
  double enter = -kInfinity;
  double leave = kInfinity;
  int axis = 0;
  for (int i = 0; i < 3; ++i) {
    const Slab slab = cross(eye[i], direction[i], half[i]);
    if (slab.enter > enter) {
      enter = slab.enter;
      axis = i;
    }
    leave = std::min(leave, slab.leave);
    if (enter > leave) return {};
  }
  if (enter < kNearest_m) return {};
  const int upper = direction[axis] < 0 ? 1 : 0;
  return {enter, static_cast<std::uint16_t>(solid.first_id + 2 * axis + upper)};
}

RayHit SceneView::meet_room(const Solid& solid, const Vec3& d) noexcept {
  const double eye[3] = {solid.eye.x, solid.eye.y, solid.eye.z};
  const double direction[3] = {d.x, d.y, d.z};
  const double half[3] = {solid.half.x, solid.half.y, solid.half.z};
  double enter = -kInfinity;
  double leave = kInfinity;
  int axis = 0;
  for (int i = 0; i < 3; ++i) {
    const Slab slab = cross(eye[i], direction[i], half[i]);
    enter = std::max(enter, slab.enter);
    if (slab.leave < leave) {
      leave = slab.leave;
      axis = i;
    }
  }
  if (enter > leave || leave < kNearest_m) return {};
  const int upper = direction[axis] > 0 ? 1 : 0;
  return {leave, static_cast<std::uint16_t>(solid.first_id + 2 * axis + upper)};
}

RayHit SceneView::meet_sphere(const Solid& solid, const Vec3& d) noexcept {
  const double a = dot(d, d);
  const double b = dot(d, solid.eye);
  const double c = dot(solid.eye, solid.eye) - solid.half.x * solid.half.x;
  const double root = b * b - a * c;
  if (root < 0 || c < 0) return {};
  const double z = (-b - std::sqrt(root)) / a;
  return z < kNearest_m ? RayHit{} : RayHit{z, solid.first_id};
}

RayHit SceneView::meet_cylinder(const Solid& solid, const Vec3& d) noexcept {
  const double a = d.x * d.x + d.y * d.y;
  const double b = d.x * solid.eye.x + d.y * solid.eye.y;
  const double c =
      solid.eye.x * solid.eye.x + solid.eye.y * solid.eye.y - solid.half.x * solid.half.x;
  Slab side{-kInfinity, kInfinity};
  if (a > 0) {
    const double root = b * b - a * c;
    if (root < 0) return {};
    const double width = std::sqrt(root);
    side = {(-b - width) / a, (-b + width) / a};
  } else if (c > 0) {
    return {};
  }
  const Slab ends = cross(solid.eye.z, d.z, solid.half.z);
  const double enter = std::max(side.enter, ends.enter);
  if (enter > std::min(side.leave, ends.leave) || enter < kNearest_m) return {};
  if (side.enter >= ends.enter) return {enter, solid.first_id};
  return {enter, static_cast<std::uint16_t>(solid.first_id + (d.z < 0 ? 2 : 1))};
}

RayHit SceneView::cast(double x, double y) const noexcept {
  RayHit best;
  for (const std::uint32_t index : selected_) {
    const Solid& solid = solids_[index];
    const RayRange& seen = solid.seen;
    if (x < seen.min_x || x > seen.max_x || y < seen.min_y || y > seen.max_y) continue;
    const Vec3 own = solid.axes.undo({x, y, 1});
    RayHit hit;
    switch (solid.shape) {
      case Shape::kBox:
        hit = meet_box(solid, own);
        break;
      case Shape::kRoom:
        hit = meet_room(solid, own);
        break;
      case Shape::kSphere:
        hit = meet_sphere(solid, own);
        break;
      case Shape::kCylinder:
        hit = meet_cylinder(solid, own);
        break;
    }
    if (hit.surface != 0 && (best.surface == 0 || hit.z < best.z)) best = hit;
  }
  return best;
}

}  // namespace planecast
