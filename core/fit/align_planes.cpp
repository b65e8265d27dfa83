#include "core/fit/align_planes.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/fit/region_refine.hpp"

namespace planecast {
namespace {

// How many readings' worth of variance a sum over a region has for each reading: neighbouring
// pixels of depth cameras share about half of the noise over some eight pixels.
constexpr double kSharedNoise = 72;
// Chi squared at which noise may still have turned a plane: two angles (95 %), and one.
constexpr double kTwoAngles = 6, kOneAngle = 4;
constexpr double kDegree = 3.14159265358979323846 / 180;
constexpr double kKnown = 0.7 * kDegree;  // standard deviation of a plane others may follow
constexpr double kSure = 0.25 * kDegree;  // of one that follows nobody
constexpr double kRightAngle = 0.03;      // most cosine of two planes with a common perpendicular
constexpr int kMostKnown = 16;
constexpr int kMostDirections = kMostKnown * (kMostKnown + 1) / 2;

// A plane's coefficients are the direction of its normal: a X + b Y + c Z = 1.
struct Vector {
  double x = 0, y = 0, z = 0;
};

double dot(const Vector& a, const Vector& b) noexcept {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
Vector cross(const Vector& a, const Vector& b) noexcept {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
Vector scaled(const Vector& a, double s) noexcept {
  return {s * a.x, s * a.y, s * a.z};
}
Vector minus(const Vector& a, const Vector& b) noexcept {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
Vector unit(const Vector& a) noexcept {
  return scaled(a, 1 / std::sqrt(dot(a, a)));
}

// The normal equations of a plane's fit.
struct Equations {
  Vector rows[3];

  Vector times(const Vector& v) const noexcept {
    return {dot(rows[0], v), dot(rows[1], v), dot(rows[2], v)};
  }
  bool solve(const Vector& v, Vector& out) const noexcept {
    const Vector c0 = cross(rows[1], rows[2]), c1 = cross(rows[2], rows[0]);
    const Vector c2 = cross(rows[0], rows[1]);
    const double determinant = dot(rows[0], c0);
    if (!(determinant > 0)) return false;
    // Symmetric: the columns of the adjugate are its rows.
    out = scaled({dot(c0, v), dot(c1, v), dot(c2, v)}, 1 / determinant);
    return true;
  }
};

struct Plane {
  Vector p;
  Equations equations;
  double angle = 0;  ///< standard deviation of its direction [rad]
  int region = 0;

  /// The likeliest plane in a direction, and what it adds to the squared residuals.
  double along(const Vector& direction, Vector& out) const noexcept {
    const Vector weighted = equations.times(direction);
    const double size = dot(weighted, direction);
    if (!(size > 0)) return 1e300;
    out = scaled(direction, dot(weighted, p) / size);
    const Vector off = minus(out, p);
    return dot(off, equations.times(off));
  }
  /// The likeliest one at right angles to a direction.
  double across(const Vector& direction, Vector& out) const noexcept {
    Vector step;
    if (!equations.solve(direction, step)) return 1e300;
    const double share = dot(direction, p) / dot(direction, step);
    out = minus(p, scaled(step, share));
    return share * dot(direction, p);
  }
};

// False where a plane has no certain direction at all.
bool make_plane(const PlaneSums& s, const FloatSurface& surface, Plane& out) noexcept {
  out.p = {surface.a, surface.b, surface.c};
  out.equations = {{{s.xx, s.xy, s.x}, {s.xy, s.yy, s.y}, {s.x, s.y, s.n}}};
  const double size = dot(out.p, out.p);
  Vector x, y, z, own;
  if (!(size > 0) || !out.equations.solve({1, 0, 0}, x) || !out.equations.solve({0, 1, 0}, y) ||
      !out.equations.solve({0, 0, 1}, z) || !out.equations.solve(out.p, own)) {
    return false;
  }
  // What lies along the coefficients changes the distance, not the direction.
  const double variance = x.x + y.y + z.z - dot(out.p, own) / size;
  out.angle = std::sqrt(std::max(0.0, kSharedNoise * variance / size));
  return true;
}

using Planes = std::array<Plane, kMaxSurfaces>;

// The planes of a frame, those known best first.
int collect(const RegionMap& regions, std::span<const RegionFit> fits, Planes& planes) noexcept {
  std::array<PlaneSums, kMaxSurfaces + 1> sums{};
  for (std::size_t i = 0; i < regions.labels.size(); ++i) {
    const unsigned label = regions.labels[i];
    if (label == 0 || !fits[label - 1].valid) continue;
    if (cell_residual(regions.cells[i], fits[label - 1].surface) > kCleanResidual) continue;
    sums[label].add(plane_sums(regions.cells[i]));
  }
  int count = 0;
  for (int k = 1; k <= regions.regions; ++k) {
    if (!fits[k - 1].valid || ((regions.curved >> k) & 1U) != 0) continue;
    planes[count].region = k;
    if (make_plane(sums[k], fits[k - 1].surface, planes[count])) ++count;
  }
  std::sort(planes.begin(), planes.begin() + count, [](const Plane& a, const Plane& b) {
    return a.angle != b.angle ? a.angle < b.angle : a.region < b.region;
  });
  return count;
}

// Directions that planes may take: normals known well, and common perpendiculars of two.
struct Directions {
  std::array<Vector, kMostDirections> direction;
  int count = 0;
  std::array<Vector, kMostKnown> normal;
  int normals = 0;

  void add(const Vector& p) noexcept {
    if (normals == kMostKnown) return;
    const Vector n = unit(p);
    direction[count++] = n;
    for (int i = 0; i < normals; ++i) {
      if (std::abs(dot(n, normal[i])) <= kRightAngle)
        direction[count++] = unit(cross(n, normal[i]));
    }
    normal[normals++] = n;
  }
};

// Turns a plane to the direction that its readings like best, if they may have any.
bool turn(Plane& plane, const Directions& known) noexcept {
  Vector best, out;
  double least = kTwoAngles * kSharedNoise;
  const auto look = [&](double cost) {
    if (cost >= least) return false;
    least = cost;
    best = out;
    return true;
  };
  bool found = false;
  for (int i = 0; i < known.count; ++i) found |= look(plane.along(known.direction[i], out));
  if (!found) {
    least = kOneAngle * kSharedNoise;
    for (int i = 0; i < known.count; ++i) found |= look(plane.across(known.direction[i], out));
  }
  if (found) plane.p = best;
  return found;
}

}  // namespace

int align_planes(const RegionMap& regions, std::span<RegionFit> fits) noexcept {
  Planes planes;
  const int count = collect(regions, fits, planes);
  Directions known;
  int turned = 0;
  for (int i = 0; i < count; ++i) {
    Plane& plane = planes[i];
    if (plane.angle > kSure && turn(plane, known)) {
      FloatSurface& surface = fits[plane.region - 1].surface;
      surface.a = plane.p.x;
      surface.b = plane.p.y;
      surface.c = plane.p.z;
      ++turned;
    } else if (plane.angle < kKnown) {
      known.add(plane.p);
    }
  }
  return turned;
}

}  // namespace planecast
