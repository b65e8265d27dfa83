#include "core/segment/cell_grid.hpp"

#include <algorithm>
#include <array>

#include "core/base/lanes.hpp"
#include "core/model/cell_moments.hpp"
#include "core/model/surface.hpp"

namespace planecast {
namespace {

constexpr std::uint32_t kSide = 8;
constexpr double kRayOne = 1.0 / (1 << 27);
constexpr float kSeedShare = 0.6F;  // of a cell's pixels, for a plane of its own
constexpr float kJoinShare = 0.5F;
constexpr float kLeastReadings = 4;
// Noise is found from groups of 2 x 2 cells: the residual from one plane that this share of them
// stays below, of those that are flat. Edges and curved things are in the rest.
constexpr double kNoiseShare = 0.4;
constexpr std::uint32_t kLeastGroups = 24;
constexpr double kMostNoise = 16;  // noise variances

// What the columns of half a cell add up to; the rays of a camera without distortion depend on
// the column or the row alone, so that products wait until the rows are in.
struct HalfCell {
  Float4 n = all4(0), y = n, yy = n, w = n, yw = n, ww = n;

  void add_row(Float4 depth, float dy, float w0) noexcept {
    const Int4 reading = depth > all4(0);
    const Float4 one = keep4(reading, all4(1)), row = all4(dy);
    const Float4 d = keep4(reading, all4(kInverseDepthOne) / max4(depth, all4(1)) - all4(w0));
    n += one;
    y += row * one;
    yy += row * row * one;
    w += d;
    yw += row * d;
    ww += d * d;
  }
};

// A whole cell under separable rays. dx, dy: eight columns and rows from (x0, y0).
LocalSums separable_sums(const std::uint16_t* depth, std::size_t stride, const float* dx,
                         const float* dy, float w0) noexcept {
  HalfCell left, right;
  for (std::uint32_t v = 0; v < kSide; ++v) {
    left.add_row(load4(depth + v * stride), dy[v], w0);
    right.add_row(load4(depth + v * stride + 4), dy[v], w0);
  }
  const Float4 l = load4(dx), r = load4(dx + 4);
  LocalSums out;
  out.n = sum4(left.n + right.n);
  out.x = sum4(l * left.n + r * right.n);
  out.xx = sum4(l * l * left.n + r * r * right.n);
  out.y = sum4(left.y + right.y);
  out.yy = sum4(left.yy + right.yy);
  out.xy = sum4(l * left.y + r * right.y);
  out.w = sum4(left.w + right.w);
  out.xw = sum4(l * left.w + r * right.w);
  out.yw = sum4(left.yw + right.yw);
  out.ww = sum4(left.ww + right.ww);
  return out;
}

// The same without a hole: what no depth has a say in is known from the rays.
LocalSums full_sums(const std::uint16_t* depth, std::size_t stride, const float* dx,
                    const float* dy, float w0) noexcept {
  const Float4 one = all4(kInverseDepthOne), origin = all4(w0);
  Float4 wl = all4(0), wr = wl, yw = wl, ww = wl;
  for (std::uint32_t v = 0; v < kSide; ++v) {
    const Float4 left = one / load4(depth + v * stride) - origin;
    const Float4 right = one / load4(depth + v * stride + 4) - origin;
    wl += left;
    wr += right;
    yw += all4(dy[v]) * (left + right);
    ww += left * left + right * right;
  }
  const Float4 l = load4(dx), r = load4(dx + 4), top = load4(dy), low = load4(dy + 4);
  LocalSums out;
  out.n = kSide * kSide;
  const float x = sum4(l + r), y = sum4(top + low);
  out.x = kSide * x;
  out.xx = kSide * sum4(l * l + r * r);
  out.y = kSide * y;
  out.yy = kSide * sum4(top * top + low * low);
  out.xy = x * y;
  out.w = sum4(wl + wr);
  out.xw = sum4(l * wl + r * wr);
  out.yw = sum4(yw);
  out.ww = sum4(ww);
  return out;
}

bool has_hole(const std::uint16_t* depth, std::size_t stride) noexcept {
  Count8 zero = {};
  for (std::uint32_t v = 0; v < kSide; ++v)
    zero |= reinterpret_cast<Count8>(load8(depth + v * stride) == Count8{});
  return nonzero_bits8(zero) != 0;
}

// Any cell, pixel by pixel: distorted rays, and the border of the image.
LocalSums any_sums(const RayTable& rays, const std::uint16_t* depth, std::uint32_t u0,
                   std::uint32_t v0, std::uint32_t wide, std::uint32_t high, std::int32_t x0,
                   std::int32_t y0, float w0) noexcept {
  LocalSums out;
  for (std::uint32_t v = 0; v < high; ++v) {
    for (std::uint32_t u = 0; u < wide; ++u) {
      const std::uint16_t count = depth[std::size_t{v0 + v} * rays.width + u0 + u];
      if (count == 0) continue;
      const float x = static_cast<float>((rays.x(u0 + u, v0 + v) - x0) * kRayOne);
      const float y = static_cast<float>((rays.y(u0 + u, v0 + v) - y0) * kRayOne);
      const float w = kInverseDepthOne / static_cast<float>(count) - w0;
      out.add(x, y, w);
    }
  }
  return out;
}

}  // namespace

void CellGrid::layout(Arena& arena, std::uint32_t max_width, std::uint32_t max_height) noexcept {
  cells_ = arena.take<Cell>(std::size_t{(max_width + 7) / 8} * ((max_height + 7) / 8));
  columns_ = arena.take<float>(std::size_t{(max_width + 7) / 8} * 8);
}

Status CellGrid::process(const StreamConfig& config, const RayTable& rays,
                         std::span<const std::uint16_t> depth) noexcept {
  if (depth.size() != std::size_t{rays.width} * rays.height) return Status::kWrongSize;
  wide_ = (rays.width + 7U) / 8U;
  high_ = (rays.height + 7U) / 8U;
  if (std::size_t{wide_} * high_ > cells_.size() || rays.width > columns_.size()) {
    wide_ = high_ = 0;
    return Status::kFrameTooLarge;
  }
  measure_cells(rays, depth, InverseNoise(config));
  noise_factor_ = static_cast<float>(found_noise());
  if (noise_factor_ > 1) {
    for (Cell& cell : cells_.first(std::size_t{wide_} * high_)) cell.variance *= noise_factor_;
  }
  return Status::kOk;
}

void CellGrid::measure_cells(const RayTable& rays, std::span<const std::uint16_t> depth,
                             const InverseNoise& noise) noexcept {
  const auto middle = [](std::uint32_t at, std::uint32_t size) {
    return std::min(at / kSide * kSide + 4, size - 1);
  };
  if (rays.separable) {
    for (std::uint32_t u = 0; u < rays.width; ++u) {
      columns_[u] = static_cast<float>((rays.x(u, 0) - rays.x(middle(u, rays.width), 0)) * kRayOne);
    }
  }
  std::array<float, kSide> rows{};
  for (std::uint32_t cy = 0; cy < high_; ++cy) {
    const std::uint32_t v0 = cy * kSide, high = std::min<std::uint32_t>(kSide, rays.height - v0);
    const std::uint32_t vm = middle(v0, rays.height);
    if (rays.separable) {
      for (std::uint32_t v = 0; v < high; ++v) {
        rows[v] = static_cast<float>((rays.y(0, v0 + v) - rays.y(0, vm)) * kRayOne);
      }
    }
    for (std::uint32_t cx = 0; cx < wide_; ++cx) {
      const std::uint32_t u0 = cx * kSide, wide = std::min<std::uint32_t>(kSide, rays.width - u0);
      const std::uint32_t um = middle(u0, rays.width);
      const std::uint16_t* first = depth.data() + std::size_t{v0} * rays.width + u0;
      Cell& cell = cells_[std::size_t{cy} * wide_ + cx];
      cell = {};
      const float w0 = cell_origin(first, rays.width, wide, high);
      if (w0 == 0) continue;
      const std::int32_t x0 = rays.x(um, vm), y0 = rays.y(um, vm);
      const LocalSums sums = !(rays.separable && wide == kSide && high == kSide)
                                 ? any_sums(rays, depth.data(), u0, v0, wide, high, x0, y0, w0)
                             : has_hole(first, rays.width)
                                 ? separable_sums(first, rays.width, &columns_[u0], rows.data(), w0)
                                 : full_sums(first, rays.width, &columns_[u0], rows.data(), w0);
      const bool spread = set_moments(sums, cell);
      cell.x += static_cast<float>(x0 * kRayOne);
      cell.y += static_cast<float>(y0 * kRayOne);
      cell.w += w0;
      const double sigma = noise.sigma(double{cell.w});
      cell.variance = static_cast<float>(sigma * sigma);
      const auto area = static_cast<float>(wide * high);
      cell.usable = spread && cell.n >= std::max(kLeastReadings, kJoinShare * area);
      cell.flat = spread && cell.n >= std::max(kLeastReadings, kSeedShare * area);
    }
  }
}

// How much noisier the frame is than the model, as a factor of the variances, at least 1.
double CellGrid::found_noise() const noexcept {
  constexpr std::uint32_t kBins = 256;  // sixteenths of a noise variance below 16
  std::array<std::uint32_t, kBins> bins{};
  std::uint32_t groups = 0;
  for (std::uint32_t cy = 0; cy + 1 < high_; cy += 2) {
    for (std::uint32_t cx = (cy & 2U) != 0 ? 2 : 0; cx + 1 < wide_; cx += 4) {
      const Cell* top = &cells_[std::size_t{cy} * wide_ + cx];
      const Cell* bottom = top + wide_;
      if (!top[0].flat || !top[1].flat || !bottom[0].flat || !bottom[1].flat) continue;
      PlaneSums sums = plane_sums(top[0]);
      for (const Cell* cell : {top + 1, bottom, bottom + 1}) sums.add(plane_sums(*cell));
      FloatSurface plane;
      if (!sums.solve(plane)) continue;
      const double readings =
          double{top[0].n} + double{top[1].n} + double{bottom[0].n} + double{bottom[1].n};
      const double variances = sums.mean_square(plane) * sums.n / readings;
      ++bins[static_cast<std::uint32_t>(std::min(variances * 16, kBins - 1.0))];
      ++groups;
    }
  }
  if (groups < kLeastGroups) return 1;
  std::uint32_t below = 0, bin = 0;
  while (below + bins[bin] <= kNoiseShare * groups) below += bins[bin++];
  return std::clamp((bin + 1) / 16.0, 1.0, kMostNoise);
}

}  // namespace planecast
