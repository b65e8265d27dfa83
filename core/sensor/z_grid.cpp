#include "core/sensor/z_grid.hpp"

namespace planecast {
namespace {

constexpr std::uint64_t kUnitsPm[] = {1'000'000'000, 500'000'000, 250'000'000,
                                      200'000'000,   125'000'000, 100'000'000};

// All three coordinates are finite.
bool valid(const Point3f& p) noexcept {
  return p.x - p.x == 0.0F && p.y - p.y == 0.0F && p.z - p.z == 0.0F;
}

bool holds_everywhere(const ZGrid& grid, const PointCloud& cloud) noexcept {
  bool any = false;
  for (const Point3f& p : cloud.points) {
    if (!valid(p)) continue;
    if (grid_count(grid, p.z) == 0) return false;
    any = true;
  }
  return any;
}

}  // namespace

std::uint16_t grid_count(const ZGrid& grid, float z) noexcept {
  const double count = static_cast<double>(z) * 1e12 / static_cast<double>(grid.unit_pm) + 0.5;
  if (!(count >= 1.0 && count < 65536.0)) return 0;
  const auto nearest = static_cast<std::uint16_t>(count);
  return grid_z(grid, nearest) == z ? nearest : std::uint16_t{0};
}

std::optional<ZGrid> find_z_grid(const PointCloud& cloud) noexcept {
  for (const std::uint64_t unit_pm : kUnitsPm) {
    for (const auto rule : {ZGrid::Rule::kDoubleProduct, ZGrid::Rule::kFloatProduct}) {
      const ZGrid grid{unit_pm, rule};
      if (holds_everywhere(grid, cloud)) return grid;
    }
  }
  return std::nullopt;
}

}  // namespace planecast
