#include "core/wire/frame_pack_cost.hpp"

#include <algorithm>
#include <bit>
#include <cstdlib>

namespace planecast {
namespace {

constexpr std::uint32_t kBlockCost = 24;  // all costs in 1/16 bit
constexpr std::uint32_t kReadingCost = 3;
constexpr std::uint32_t kCorrectionCost = 40;
constexpr std::uint32_t kDoublingCost = 20;  // of a correction of twice the steps
constexpr std::uint32_t kMixedCost = 5;

}  // namespace

std::uint32_t block_cost(const CodingTables& tables, const FrameModel& frame, std::uint32_t bx,
                         std::uint32_t by) noexcept {
  const CameraModel& camera = tables.config->camera;
  const std::uint32_t u1 = std::min<std::uint32_t>(bx * 8 + 8, camera.width);
  const std::uint32_t v1 = std::min<std::uint32_t>(by * 8 + 8, camera.height);
  const std::uint8_t* half_widths = tables.bounds->half_widths(tables.bounds->ray_class(bx, by));
  const auto level_of = [&](std::uint16_t depth) { return int{tables.levels->nearest(depth)}; };
  std::uint32_t readings = 0, corrections = 0, pixels = 0;
  // Every fourth row tells enough.
  for (std::uint32_t v = by * 8 + (by * 8 + 1 < v1 ? 1 : 0); v < v1; v += 4) {
    const std::uint16_t* row = &frame.depth[std::size_t{v} * camera.width];
    const std::uint16_t* above = v > 0 ? row - camera.width : row;
    int left = bx > 0 ? level_of(row[bx * 8 - 1]) : 0;
    for (std::uint32_t u = bx * 8; u < u1; ++u) {
      ++pixels;
      const int level = level_of(row[u]), up = level_of(above[u]);
      const int expected = left != 0 && up != 0 ? (left + up) / 2 : left + up;
      left = level;
      if (level == 0) continue;
      ++readings;
      const auto error = static_cast<std::uint32_t>(std::abs(level - expected));
      const std::uint32_t half = half_widths[level];
      if (error <= half) continue;
      corrections +=
          kCorrectionCost +
          kDoublingCost * static_cast<std::uint32_t>(std::bit_width(error) - std::bit_width(half));
    }
  }
  if (readings == 0) return 2;
  return kBlockCost + 4 * (readings * kReadingCost + corrections +
                           (readings < pixels ? pixels * kMixedCost : 0));
}

}  // namespace planecast
