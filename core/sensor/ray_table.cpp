#include "core/sensor/ray_table.hpp"

#include "core/base/int128.hpp"

namespace planecast {
namespace {

constexpr int kIterations = 20;                        // Newton's limit; 3 to 6 are usual
constexpr std::int64_t kOne = std::int64_t{1} << 30U;  // 1.0 in Q30
constexpr std::int64_t kMaxRayQ30 = kMaxRay * kOne;
constexpr std::int64_t kMaxSlopeQ30 = std::int64_t{1} << 42U;  // keeps every product in range
constexpr std::int64_t kMinDeterminantQ30 = kOne / 1024;
constexpr std::int64_t kMaxResidualQ30 = std::int64_t{1} << 10U;  // 2^-20

// Product of two Q30 numbers, rounded down.
std::int64_t mul(std::int64_t a, std::int64_t b) noexcept {
  return static_cast<std::int64_t>((Int128{a} * b) >> 30);
}

std::int64_t magnitude(std::int64_t value) noexcept {
  return value < 0 ? -value : value;
}

// round(numerator / denominator), halves up; denominator > 0.
std::int64_t divide_rounded(std::int64_t numerator, std::int64_t denominator) noexcept {
  const std::int64_t doubled = 2 * numerator + denominator;
  const std::int64_t divisor = 2 * denominator;
  const std::int64_t quotient = doubled / divisor;
  return (doubled % divisor < 0) ? quotient - 1 : quotient;
}

// (pixel - centre) / focal with `fraction_bits` (at most 30) bits. The offset is below 1.5 * 2^31,
// so twice the numerator stays below 2^63.
std::int64_t normalised(std::uint32_t pixel, std::int32_t centre_q16, std::uint32_t focal_q16,
                        unsigned fraction_bits) noexcept {
  const std::int64_t offset_q16 = std::int64_t{pixel} * 65536 - centre_q16;
  return divide_rounded(offset_q16 * (std::int64_t{1} << fraction_bits), focal_q16);
}

// Coefficients in Q30.
struct Lens {
  std::int64_t k1, k2, p1, p2, k3;
};

struct Ray {
  std::int64_t x, y;  // Q30
};

// Distorted position of a ray and its derivatives, all Q30.
struct Projection {
  std::int64_t x, y;
  std::int64_t xx, xy, yy;  // dx/dx, dx/dy = dy/dx, dy/dy
};

// Brown-Conrady forward: x (1 + k1 r2 + k2 r4 + k3 r6) + 2 p1 x y + p2 (r2 + 2 x^2), and so for y.
// With |x|, |y| <= 8 and |k| < 128 every value stays below 2^62.
Projection project(const Lens& lens, const Ray& ray) noexcept {
  const std::int64_t x2 = mul(ray.x, ray.x);
  const std::int64_t y2 = mul(ray.y, ray.y);
  const std::int64_t xy = mul(ray.x, ray.y);
  const std::int64_t r2 = x2 + y2;
  const std::int64_t radial = kOne + mul(r2, lens.k1 + mul(r2, lens.k2 + mul(r2, lens.k3)));
  const std::int64_t slope =  // d radial / d r2
      lens.k1 + mul(r2, 2 * lens.k2 + mul(r2, 3 * lens.k3));
  const std::int64_t p1x = mul(lens.p1, ray.x);
  const std::int64_t p1y = mul(lens.p1, ray.y);
  const std::int64_t p2x = mul(lens.p2, ray.x);
  const std::int64_t p2y = mul(lens.p2, ray.y);
  Projection out;
  out.x = mul(ray.x, radial) + 2 * mul(lens.p1, xy) + mul(lens.p2, r2 + 2 * x2);
  out.y = mul(ray.y, radial) + mul(lens.p1, r2 + 2 * y2) + 2 * mul(lens.p2, xy);
  out.xx = radial + 2 * mul(x2, slope) + 2 * p1y + 6 * p2x;
  out.xy = 2 * mul(xy, slope) + 2 * p1x + 2 * p2y;
  out.yy = radial + 2 * mul(y2, slope) + 6 * p1y + 2 * p2x;
  return out;
}

bool tame(const Projection& p) noexcept {
  return magnitude(p.x) < kMaxSlopeQ30 && magnitude(p.y) < kMaxSlopeQ30 &&
         magnitude(p.xx) < kMaxSlopeQ30 && magnitude(p.xy) < kMaxSlopeQ30 &&
         magnitude(p.yy) < kMaxSlopeQ30;
}

std::int64_t determinant(const Projection& p) noexcept {
  return static_cast<std::int64_t>((Int128{p.xx} * p.yy - Int128{p.xy} * p.xy) >> 30);
}

// (a * b - c * d) / det, rounded to zero, Q30; kept in 128 bits because a bad lens overshoots.
Int128 newton_step(std::int64_t a, std::int64_t b, std::int64_t c, std::int64_t d,
                   std::int64_t det) noexcept {
  return (Int128{a} * b - Int128{c} * d) / det;
}

bool beyond(Int128 value, std::int64_t limit) noexcept {
  return value > limit || value < -limit;
}

// Newton's method from the distorted position: for barrel and pincushion alike it then approaches
// the root from one side. Steps stop at zero or after kIterations. False when it leaves the allowed
// rays, folds or does not converge.
bool undistort(const Lens& lens, const Ray& target, Ray& ray) noexcept {
  ray = target;
  for (int i = 0; i < kIterations; ++i) {
    const Projection now = project(lens, ray);
    const std::int64_t det = tame(now) ? determinant(now) : 0;
    if (det < kMinDeterminantQ30) return false;
    const std::int64_t ex = target.x - now.x;
    const std::int64_t ey = target.y - now.y;
    const Int128 step_x = newton_step(now.yy, ex, now.xy, ey, det);
    const Int128 step_y = newton_step(now.xx, ey, now.xy, ex, det);
    if (beyond(ray.x + step_x, kMaxRayQ30) || beyond(ray.y + step_y, kMaxRayQ30)) return false;
    ray.x += static_cast<std::int64_t>(step_x);
    ray.y += static_cast<std::int64_t>(step_y);
    if (step_x == 0 && step_y == 0) break;
  }
  const Projection end = project(lens, ray);
  return tame(end) && determinant(end) >= kMinDeterminantQ30 &&
         magnitude(target.x - end.x) <= kMaxResidualQ30 &&
         magnitude(target.y - end.y) <= kMaxResidualQ30;
}

std::int32_t q30_to_q27(std::int64_t value) noexcept {
  return static_cast<std::int32_t>((value + 4) >> 3);
}

void fill_separable(const CameraModel& camera, std::span<std::int32_t> xs,
                    std::span<std::int32_t> ys) noexcept {
  for (std::uint32_t u = 0; u < camera.width; ++u) {
    xs[u] = static_cast<std::int32_t>(normalised(u, camera.cx_q16, camera.fx_q16, 27));
  }
  for (std::uint32_t v = 0; v < camera.height; ++v) {
    ys[v] = static_cast<std::int32_t>(normalised(v, camera.cy_q16, camera.fy_q16, 27));
  }
}

bool fill_distorted(const CameraModel& camera, std::span<std::int32_t> xs,
                    std::span<std::int32_t> ys) noexcept {
  constexpr std::int64_t kQ24ToQ30 = 64;
  const Lens lens{camera.k1_q24 * kQ24ToQ30, camera.k2_q24 * kQ24ToQ30, camera.p1_q24 * kQ24ToQ30,
                  camera.p2_q24 * kQ24ToQ30, camera.k3_q24 * kQ24ToQ30};
  std::size_t i = 0;
  for (std::uint32_t v = 0; v < camera.height; ++v) {
    const std::int64_t target_y = normalised(v, camera.cy_q16, camera.fy_q16, 30);
    for (std::uint32_t u = 0; u < camera.width; ++u, ++i) {
      const std::int64_t target_x = normalised(u, camera.cx_q16, camera.fx_q16, 30);
      Ray ray{};
      if (!undistort(lens, {target_x, target_y}, ray)) return false;
      xs[i] = q30_to_q27(ray.x);
      ys[i] = q30_to_q27(ray.y);
    }
  }
  return true;
}

}  // namespace

std::size_t ray_table_entries(const CameraModel& camera) noexcept {
  if (!camera.distorted()) return std::size_t{camera.width} + camera.height;
  return 2 * std::size_t{camera.width} * camera.height;
}

Status build_ray_table(const CameraModel& camera, std::span<std::int32_t> storage,
                       RayTable& out) noexcept {
  if (const Status status = check_camera(camera); status != Status::kOk) return status;
  if (storage.size() < ray_table_entries(camera)) return Status::kOutOfArena;
  const bool separable = !camera.distorted();
  const std::size_t x_count = separable ? camera.width : camera.pixels();
  const std::size_t y_count = separable ? camera.height : camera.pixels();
  const auto xs = storage.first(x_count);
  const auto ys = storage.subspan(x_count, y_count);
  if (separable) {
    fill_separable(camera, xs, ys);
  } else if (!fill_distorted(camera, xs, ys)) {
    return Status::kFieldRange;
  }
  out = RayTable{camera.width, camera.height, separable, xs, ys};
  return Status::kOk;
}

}  // namespace planecast
