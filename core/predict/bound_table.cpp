#include "core/predict/bound_table.hpp"

#include <algorithm>

#include "core/base/int128.hpp"
#include "core/sensor/ray_length.hpp"

namespace planecast {
namespace {

constexpr std::uint32_t kCounts = 65536;
constexpr std::uint32_t kMaxErrorQ8 = 65535U * 256U;

// Sigmas are cut here, so that any multiple of one fits 64 bits.
constexpr std::uint64_t kMaxSigmaQ8 = std::uint64_t{1} << 31U;

// Sigma of a reading in 1/256 count, rounded down. Stereo: S z^2, time of flight: S.
std::uint64_t sigma_q8(const NoiseModel& noise, std::uint64_t unit_pm,
                       std::uint32_t depth) noexcept {
  if (noise.kind == NoiseModel::Kind::kTof) {
    const std::uint64_t sigma =
        std::uint64_t{noise.s_e9} * 1000 * 256 / unit_pm;  // 1e-9 m = 1000 pm
    return std::min(sigma, kMaxSigmaQ8);
  }
  if (noise.kind != NoiseModel::Kind::kStereo) return 0;
  const std::uint64_t z_um =
      std::min<std::uint64_t>(depth * unit_pm / 1'000'000, std::uint64_t{1} << 27U);
  // S [1e-9/m] z^2 [1e-12 m^2] / unit [1e-12 m] * 256 = (z^2 >> 12) S 4096 * 256e-9 / unit_pm,
  // and 4096 * 256e-9 = 1.048576e-3; 1048/1e6 rounds towards the stricter side.
  const Int128 product = Int128{(z_um * z_um) >> 12U} * noise.s_e9 / 1000;
  const Int128 sigma = product / 1000 * 1048 / unit_pm;
  return sigma < kMaxSigmaQ8 ? static_cast<std::uint64_t>(sigma) : kMaxSigmaQ8;
}

}  // namespace

void BoundTable::layout(Arena& arena, std::uint32_t max_pixels, CodecHalf half) noexcept {
  error_q8_ = arena.take<std::uint32_t>(kCounts);
  half_width_ = arena.take<std::uint8_t>(std::size_t{kCounts} * kRayClasses);
  // A 1 x n image needs a block for each 8 pixels of its side: n/8 + 1 at the most.
  classes_ = arena.take<std::uint8_t>(max_pixels / 8 + kMaxImageSide / 4 + 64);
  if (half == CodecHalf::kEncoder)
    windows_ = arena.take<LevelWindow>(std::size_t{kCounts} * kRayClasses);
}

Status BoundTable::build(const StreamConfig& config, const RayTable& rays,
                         const LevelTable& levels) noexcept {
  lossless_ = config.tolerance == ToleranceKind::kLossless;
  blocks_wide_ = (rays.width + kBlockSide - 1U) / kBlockSide;
  const std::uint32_t blocks_high = (rays.height + kBlockSide - 1U) / kBlockSide;
  if (std::size_t{blocks_wide_} * blocks_high > classes_.size()) return Status::kFieldRange;
  build_errors(config);
  build_classes(rays);
  build_half_widths(levels);
  if (!windows_.empty()) build_windows(levels);
  return Status::kOk;
}

void BoundTable::build_errors(const StreamConfig& config) noexcept {
  const std::uint64_t unit_pm = config.camera.unit_pm;
  for (std::uint32_t depth = 0; depth < kCounts; ++depth) {
    std::uint64_t error_q8 = 0;
    switch (config.tolerance) {
      case ToleranceKind::kLossless:
        break;
      case ToleranceKind::kMetres:
        error_q8 = std::uint64_t{config.tolerance_100nm} * 100'000 * 256 / unit_pm;
        break;
      case ToleranceKind::kSigma:
      case ToleranceKind::kSurfaces:
        error_q8 = (sigma_q8(config.noise, unit_pm, depth) * config.sigmas_q16) >> 16U;
        break;
    }
    // What float32 coordinates round away, 2^-24 of a distance of at most 11.4 depths (rays end
    // at |x| = |y| = 8), and a little for the camera's own rounding to the wire.
    const std::uint64_t slack = 1 + (depth >> 12U);
    error_q8_[depth] = static_cast<std::uint32_t>(
        error_q8 <= slack ? 0 : std::min<std::uint64_t>(error_q8 - slack, kMaxErrorQ8));
  }
}

void BoundTable::build_classes(const RayTable& rays) noexcept {
  const std::uint32_t blocks_high = (rays.height + kBlockSide - 1U) / kBlockSide;
  std::uint32_t longest = 65536;
  const auto block_length = [&](std::uint32_t bx, std::uint32_t by) {
    // |(x, y, 1)| is convex in the pixel for the lens models in use, so a block's longest ray is
    // at its border; every pixel of the border is tried, since distortion may bend it.
    std::uint32_t most = 65536;
    const std::uint32_t u0 = bx * kBlockSide;
    const std::uint32_t v0 = by * kBlockSide;
    const std::uint32_t u1 = std::min<std::uint32_t>(u0 + kBlockSide, rays.width) - 1;
    const std::uint32_t v1 = std::min<std::uint32_t>(v0 + kBlockSide, rays.height) - 1;
    for (std::uint32_t v = v0; v <= v1; ++v) {
      const std::uint32_t step = (v == v0 || v == v1 || u1 == u0) ? 1 : u1 - u0;
      for (std::uint32_t u = u0; u <= u1; u += step) {
        most = std::max(most, ray_length_q16(rays.x(u, v), rays.y(u, v)));
      }
    }
    return most;
  };
  for (std::uint32_t by = 0; by < blocks_high; ++by) {
    for (std::uint32_t bx = 0; bx < blocks_wide_; ++bx)
      longest = std::max(longest, block_length(bx, by));
  }
  // Classes are even in length from 1 to the longest ray; a class is as strict as its upper end.
  const std::uint32_t span = longest - 65536 + 1;
  for (int c = 0; c < kRayClasses; ++c) {
    const std::uint64_t upper =
        65536 + (std::uint64_t{span} * (c + 1) + kRayClasses - 1) / kRayClasses;
    inverse_length_q16_[c] = static_cast<std::uint32_t>((std::uint64_t{1} << 32U) / upper);
  }
  for (std::uint32_t by = 0; by < blocks_high; ++by) {
    for (std::uint32_t bx = 0; bx < blocks_wide_; ++bx) {
      const std::uint64_t over = block_length(bx, by) - 65536;
      classes_[std::size_t{by} * blocks_wide_ + bx] =
          static_cast<std::uint8_t>(over * kRayClasses / span);
    }
  }
}

void BoundTable::build_half_widths(const LevelTable& levels) noexcept {
  for (int c = 0; c < kRayClasses; ++c) {
    std::uint8_t* row = half_width_.data() + std::size_t(c) * kCounts;
    if (lossless_) {
      std::fill(row, row + kCounts, std::uint8_t{0});
      continue;
    }
    std::uint32_t reach = 1;
    for (std::uint32_t level = 1; level < levels.count(); ++level) {
      const std::uint32_t limit =
          levels.depth(level) + max_error(levels.depth(level), static_cast<std::uint8_t>(c));
      reach = std::max(reach, level);
      while (reach + 1 < levels.count() && levels.depth(reach + 1) <= limit) ++reach;
      row[level] = static_cast<std::uint8_t>(std::min<std::uint32_t>(reach - level, kMaxHalfWidth));
    }
  }
}

void BoundTable::build_windows(const LevelTable& levels) noexcept {
  for (int c = 0; c < kRayClasses; ++c) {
    LevelWindow* row = windows_.data() + std::size_t(c) * kCounts;
    row[0] = {};
    for (std::uint32_t depth = 1; depth < kCounts; ++depth) {
      const auto count = static_cast<std::uint16_t>(depth);
      const std::uint32_t error = max_error(count, static_cast<std::uint8_t>(c));
      const std::uint32_t least = depth > error ? depth - error : 1;
      const std::uint32_t most = std::min(depth + error, kCounts - 1);
      std::uint32_t low = levels.nearest(static_cast<std::uint16_t>(least));
      std::uint32_t high = levels.nearest(static_cast<std::uint16_t>(most));
      low += levels.depth(low) < least ? 1 : 0;
      high -= levels.depth(high) > most ? 1 : 0;
      row[depth] = {static_cast<std::uint16_t>(low), static_cast<std::uint16_t>(high)};
    }
  }
}

}  // namespace planecast
