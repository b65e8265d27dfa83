#include "core/sensor/z_grid.hpp"

namespace planecast {
namespace {

constexpr std::uint64_t kUnitsPm[] = {1'000'000'000, 500'000'000, 250'000'000,
                                      200'000'000,   125'000'000, 100'000'000};

// printf("%.7g") followed by a correct read, for 0 <= value < 10^5. value * 10^n is exact in double
// for n <= 12, since 24 bits times 5^n fit 53 bits; a tie goes to even, as in glibc.
float print_and_read(float value) noexcept {
  double scale = 1e6;  // 7 significant digits of [1, 10)
  for (double v = value; v >= 10.0; v /= 10.0) scale /= 10.0;
  for (double v = value; v < 1.0 && scale < 1e12; v *= 10.0) scale *= 10.0;
  const double digits = value * scale;
  auto whole = static_cast<std::int64_t>(digits);
  const double rest = digits - static_cast<double>(whole);
  if (rest > 0.5 || (rest == 0.5 && whole % 2 != 0)) ++whole;
  return static_cast<float>(static_cast<double>(whole) / scale);
}

// The count whose depth is nearest to z [m]; 0: none of them.
std::uint16_t nearest_count(const ZGrid& grid, float z) noexcept {
  const double counts_per_metre = 1e12 / static_cast<double>(grid.unit_pm);
  const double count = static_cast<double>(z) * counts_per_metre + 0.5;
  return count >= 1.0 && count < 65536.0 ? static_cast<std::uint16_t>(static_cast<int>(count))
                                         : std::uint16_t{0};
}

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

float grid_z(const ZGrid& grid, std::uint16_t count) noexcept {
  const double unit = static_cast<double>(grid.unit_pm) / 1e12;
  if (grid.rule == ZGrid::Rule::kDoubleProduct) return static_cast<float>(count * unit);
  const float product = static_cast<float>(count) * static_cast<float>(unit);
  return grid.rule == ZGrid::Rule::kFloatProduct ? product : print_and_read(product);
}

std::uint16_t grid_count(const ZGrid& grid, float z) noexcept {
  const std::uint16_t nearest = nearest_count(grid, z);
  return nearest != 0 && grid_z(grid, nearest) == z ? nearest : std::uint16_t{0};
}

ZGridTable::ZGridTable(const ZGrid& grid) : z_(65536) {
  for (std::uint32_t count = 1; count < 65536; ++count)
    z_[count] = grid_z(grid, static_cast<std::uint16_t>(count));
}

std::optional<ZGrid> find_z_grid(const PointCloud& cloud) noexcept {
  for (const std::uint64_t unit_pm : kUnitsPm) {
    for (const auto rule :
         {ZGrid::Rule::kDoubleProduct, ZGrid::Rule::kFloatProduct, ZGrid::Rule::kPrinted7}) {
      const ZGrid grid{unit_pm, rule};
      if (holds_everywhere(grid, cloud)) return grid;
    }
  }
  return std::nullopt;
}

}  // namespace planecast
