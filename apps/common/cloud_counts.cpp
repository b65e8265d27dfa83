#include "apps/common/cloud_counts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <limits>

#include "core/base/lanes.hpp"

namespace planecast {
namespace {

constexpr std::uint32_t kLanes = 4;
constexpr std::int32_t kMostCount = 65535;

// Four points of a row, one coordinate a vector.
struct Points4 {
  Float4 x, y, z;
};

Points4 load_points(const Point3f* points) noexcept {
  const auto* const from = reinterpret_cast<const float*>(points);
  const Float4 a = load4(from), b = load4(from + 4), c = load4(from + 8);  // x0y0z0x1 y1z1x2y2 ...
  const Float4 x2_x3 = __builtin_shufflevector(b, c, 2, 5, 2, 5);
  const Float4 y0_y1 = __builtin_shufflevector(a, b, 1, 4, 1, 4);
  const Float4 y2_y3 = __builtin_shufflevector(b, c, 3, 6, 3, 6);
  const Float4 z0_z1 = __builtin_shufflevector(a, b, 2, 5, 2, 5);
  return {__builtin_shufflevector(a, x2_x3, 0, 3, 4, 5),
          __builtin_shufflevector(y0_y1, y2_y3, 0, 1, 4, 5),
          __builtin_shufflevector(z0_z1, c, 0, 1, 4, 7)};
}

// Two of them, in double.
struct Points2 {
  Double2 x, y, z;
};

Points2 first2(const Points4& p) noexcept {
  return {planecast::first2(p.x), planecast::first2(p.y), planecast::first2(p.z)};
}
Points2 last2(const Points4& p) noexcept {
  return {planecast::last2(p.x), planecast::last2(p.y), planecast::last2(p.z)};
}

// is_depth_reading() of four.
Int4 readings_of(const Points4& p) noexcept {
  const Int4 finite = ((p.x - p.x) + (p.y - p.y) + (p.z - p.z)) == 0;
  return finite & ((p.x != 0) | (p.y != 0) | (p.z != 0));
}

// Counts four points at a time.
class FourPoints {
 public:
  FourPoints(const StreamSetup& setup, Proof proof);

  // Returns a bit for each point that has no count, or lies too far from its count's point; the
  // first lowest.
  unsigned count(const Point3f* points, Int4 ray_x, Int4 ray_y,
                 std::uint16_t* counts) const noexcept;

 private:
  Double2 depth(const Points2& p) const noexcept { return axes_.depth(p.x, p.y, p.z); }
  Double2 steps(Double2 depth) const noexcept;
  Int4 gated(Int4 nearest) const noexcept;
  Int4 on_grid(Int4 nearest, Float4 z) const noexcept;
  Double2 excess(const Points2& p, Double2 ray_x, Double2 ray_y, Double2 depth,
                 Double2 count) const noexcept;

  OpticalAxes axes_;
  const ZGridTable* grid_;
  BoundCurve allowed_;                   // what a point may lie off its count's own
  double unit_, counts_per_metre_;       // metres of a count, and the reverse
  std::int32_t least_, most_;            // of the range limits
  std::int32_t below_ = 0, beyond_ = 0;  // the count of a reading outside of them; 0: its own
  bool measured_;
};

FourPoints::FourPoints(const StreamSetup& setup, Proof proof)
    : axes_(setup.encoder.stream),
      grid_(setup.grid.get()),
      allowed_(setup.encoder.stream.tolerance == ToleranceKind::kLossless
                   ? BoundCurve{kExactResidual_m, 0}
                   : setup.contract.bound_curve().times(setup.allowed_share)),
      unit_(static_cast<double>(setup.encoder.stream.camera.unit_pm) * 1e-12),
      counts_per_metre_(1 / unit_),
      least_(setup.encoder.stages.range_min),
      most_(setup.encoder.stages.range_max),
      below_(least_ > 1 ? 1 : 0),
      beyond_(most_ < kMostCount ? kMostCount : 0),
      measured_(proof == Proof::kMisfit) {}

// Counts from the origin, plus a half, to be cut: of what lies far beyond all counts, one beyond
// them; of no number, none.
Double2 FourPoints::steps(Double2 depth) const noexcept {
  constexpr Double2 kLow = {-1, -1}, kHigh = {1e6, 1e6};
  Double2 steps = depth * counts_per_metre_;
  steps = steps > kLow ? steps : kLow;
  steps = steps < kHigh ? steps : kHigh;
  return steps + 0.5;
}

// A count that the filter's range gate will refuse, for a reading outside its limits; 0: inside, or
// no count is refused.
Int4 FourPoints::gated(Int4 nearest) const noexcept {
  return ((nearest < least_) & below_) | ((nearest > most_) & beyond_);
}

// The counts whose z is exactly the points' own; 0 where there is none.
Int4 FourPoints::on_grid(Int4 nearest, Float4 z) const noexcept {
  nearest &= (nearest > 0) & (nearest <= kMostCount);
  const Float4 own = {grid_->z(nearest[0]), grid_->z(nearest[1]), grid_->z(nearest[2]),
                      grid_->z(nearest[3])};
  return nearest & (own == z);
}

// Squared distances from the counts' own points, less what is allowed [m^2].
Double2 FourPoints::excess(const Points2& p, Double2 ray_x, Double2 ray_y, Double2 depth,
                           Double2 count) const noexcept {
  const auto made = axes_.point(ray_x * kRayUnit, ray_y * kRayUnit, count * unit_);
  const Double2 x = p.x - made.x, y = p.y - made.y, z = p.z - made.z;
  const Double2 allowed = allowed_.at(depth);
  return x * x + y * y + z * z - allowed * allowed;
}

unsigned FourPoints::count(const Point3f* points, Int4 ray_x, Int4 ray_y,
                           std::uint16_t* counts) const noexcept {
  const Points4 p = load_points(points);
  const Points2 first = first2(p), last = last2(p);
  const Double2 first_depth = depth(first), last_depth = depth(last);
  const Int4 reading = readings_of(p);
  const Int4 near = whole4(steps(first_depth), steps(last_depth));
  const Int4 gate = gated(near);
  const Int4 kept = reading & (gate == 0);
  const Int4 count = grid_ != nullptr ? on_grid(near, p.z) : near;
  const Count4 out = __builtin_convertvector((kept & count) | (reading & gate), Count4);
  std::memcpy(counts, &out, sizeof out);
  Int4 off = (count < 1) | (count > kMostCount);
  if (measured_) {
    off |= positive4(excess(first, planecast::first2(ray_x), planecast::first2(ray_y), first_depth,
                            planecast::first2(count)),
                     excess(last, planecast::last2(ray_x), planecast::last2(ray_y), last_depth,
                            planecast::last2(count)));
  }
  return lane_bits(kept & off);
}

// The last points of a row, as many as are left, among holes.
struct RowEnd {
  std::array<Point3f, kLanes> points;
  std::array<std::int32_t, kLanes> ray_x{}, ray_y{};
  std::array<std::uint16_t, kLanes> counts{};

  RowEnd() {
    constexpr float kHole = std::numeric_limits<float>::quiet_NaN();
    points.fill({kHole, kHole, kHole});
  }
};

// Where the row's rays begin; y of separable rays is one number.
struct RowRays {
  const std::int32_t *x, *y;
  bool same_y;

  RowRays(const RayTable& rays, std::uint32_t v)
      : x(rays.x_q27.data() + (rays.separable ? 0 : std::size_t{v} * rays.width)),
        y(rays.y_q27.data() + (rays.separable ? v : std::size_t{v} * rays.width)),
        same_y(rays.separable) {}
  Int4 y4(std::uint32_t u) const noexcept { return same_y ? Int4{*y, *y, *y, *y} : load4(y + u); }
};

unsigned count_row_end(const FourPoints& four, const Point3f* points, const RowRays& rays,
                       std::uint32_t u, std::uint32_t left, std::uint16_t* counts) {
  RowEnd end;
  std::copy_n(points + u, left, end.points.begin());
  std::copy_n(rays.x + u, left, end.ray_x.begin());
  if (rays.same_y)
    end.ray_y.fill(*rays.y);
  else
    std::copy_n(rays.y + u, left, end.ray_y.begin());
  const unsigned off = four.count(end.points.data(), load4(end.ray_x.data()),
                                  load4(end.ray_y.data()), end.counts.data());
  std::copy_n(end.counts.begin(), left, counts + u);
  return off;
}

// Returns the first point of the row that is off, else its width.
std::uint32_t count_row(const FourPoints& four, const Point3f* points, const RowRays& rays,
                        std::uint32_t width, std::uint16_t* counts) {
  std::uint32_t u = 0;
  for (; u + kLanes <= width; u += kLanes) {
    const unsigned off = four.count(points + u, load4(rays.x + u), rays.y4(u), counts + u);
    if (off != 0) return u + static_cast<std::uint32_t>(std::countr_zero(off));
  }
  if (u == width) return width;
  const unsigned off = count_row_end(four, points, rays, u, width - u, counts);
  return off != 0 ? u + static_cast<std::uint32_t>(std::countr_zero(off)) : width;
}

Error off_the_stream(const SensorFrame& frame, std::uint32_t u, std::uint32_t v) {
  return {Status::kBoundExceeded,
          fmt::format("{}: point {} (column {}, row {}) does not lie on the depth grid and camera "
                      "of the stream's first frame; encode it as a stream of its own",
                      frame.name, std::size_t{v} * frame.cloud.width + u, u, v)};
}

}  // namespace

Result<Done> count_cloud(const StreamSetup& setup, const SensorFrame& frame, Proof proof,
                         std::vector<std::uint16_t>& depth) {
  const FourPoints four(setup, proof);
  const RayTable& rays = setup.rays->table;
  depth.resize(frame.cloud.points.size());
  for (std::uint32_t v = 0; v < rays.height; ++v) {
    const std::size_t row = std::size_t{v} * rays.width;
    const std::uint32_t u =
        count_row(four, &frame.cloud.points[row], RowRays(rays, v), rays.width, &depth[row]);
    if (u < rays.width) return off_the_stream(frame, u, v);
  }
  return Done{};
}

}  // namespace planecast
