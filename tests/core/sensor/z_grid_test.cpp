// Depth grids in float clouds: every rule against what a recorder would really have done.
#include "core/sensor/z_grid.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <limits>

#include "core/base/random.hpp"

namespace planecast {
namespace {

constexpr float kHole = std::numeric_limits<float>::quiet_NaN();

PointCloud cloud_of(const std::function<float(int)>& z_of_count) {
  Pcg32 random(1);
  PointCloud cloud;
  cloud.width = 200;
  cloud.height = 100;
  for (int i = 0; i < 20000; ++i) {
    const int count = 300 + static_cast<int>(random.below(8000));
    cloud.points.push_back(i % 7 == 0 ? Point3f{kHole, kHole, kHole}
                                      : Point3f{0, 0, z_of_count(count)});
  }
  return cloud;
}

TEST(ZGrid, CountsAndFloatsAreInverseOnEveryGrid) {
  for (const std::uint64_t unit :
       {1'000'000'000ULL, 250'000'000ULL, 200'000'000ULL, 100'000'000ULL}) {
    for (const auto rule :
         {ZGrid::Rule::kDoubleProduct, ZGrid::Rule::kFloatProduct, ZGrid::Rule::kPrinted7}) {
      const ZGrid grid{unit, rule};
      const ZGridTable table(grid);
      for (int k = 1; k <= 65535; ++k) {
        const float z = grid_z(grid, static_cast<std::uint16_t>(k));
        ASSERT_EQ(grid_count(grid, z), k);
        ASSERT_EQ(grid_count(grid, std::nextafter(z, 100.0F)), 0);
        ASSERT_EQ(table.z(k), z);
      }
      for (const float z : {0.0F, -1.0F, 1e9F, std::nanf("")}) ASSERT_EQ(grid_count(grid, z), 0);
    }
  }
}

TEST(ZGrid, RulesAreWhatRecordersDo) {
  for (int k = 1; k <= 65535; ++k) {
    const auto count = static_cast<std::uint16_t>(k);
    ASSERT_EQ(grid_z({1'000'000'000, ZGrid::Rule::kDoubleProduct}, count),
              static_cast<float>(k) / 1000.0F);
    const float product = static_cast<float>(k) * 0.001F;
    ASSERT_EQ(grid_z({1'000'000'000, ZGrid::Rule::kFloatProduct}, count), product);
    char text[32];
    std::snprintf(text, sizeof text, "%.7g", static_cast<double>(product));
    ASSERT_EQ(grid_z({1'000'000'000, ZGrid::Rule::kPrinted7}, count), std::strtof(text, nullptr))
        << k;
  }
}

TEST(ZGrid, FindsMillimetresByEitherProduct) {
  const auto by_double = find_z_grid(cloud_of([](int k) { return static_cast<float>(k * 0.001); }));
  ASSERT_TRUE(by_double.has_value());
  EXPECT_EQ(*by_double, (ZGrid{1'000'000'000, ZGrid::Rule::kDoubleProduct}));
  const auto by_float = find_z_grid(cloud_of([](int k) { return static_cast<float>(k) * 0.001F; }));
  ASSERT_TRUE(by_float.has_value());
  EXPECT_EQ(*by_float, (ZGrid{1'000'000'000, ZGrid::Rule::kFloatProduct}));
}

TEST(ZGrid, FindsFinerUnits) {
  const auto fifth = find_z_grid(cloud_of([](int k) { return static_cast<float>(k * 0.0002); }));
  ASSERT_TRUE(fifth.has_value());
  EXPECT_EQ(fifth->unit_pm, 200'000'000U);
  const auto eighth = find_z_grid(cloud_of([](int k) { return static_cast<float>(k * 0.000125); }));
  ASSERT_TRUE(eighth.has_value());
  EXPECT_EQ(eighth->unit_pm, 125'000'000U);
}

TEST(ZGrid, OneValueOffByOneBitIsNoGrid) {
  PointCloud cloud = cloud_of([](int k) { return static_cast<float>(k * 0.001); });
  cloud.points[9].z = std::nextafterf(cloud.points[9].z, 100.0F);
  EXPECT_FALSE(find_z_grid(cloud).has_value());
}

TEST(ZGrid, NothingIsProvenByHolesNegativesOrLargeValues) {
  EXPECT_FALSE(find_z_grid(cloud_of([](int) { return kHole; })).has_value());
  EXPECT_FALSE(
      find_z_grid(cloud_of([](int k) { return static_cast<float>(k * -0.001); })).has_value());
  EXPECT_FALSE(find_z_grid(cloud_of([](int) { return 0.0F; })).has_value());
  EXPECT_FALSE(find_z_grid(cloud_of([](int) { return 66.0F; })).has_value());
  EXPECT_FALSE(find_z_grid(PointCloud{}).has_value());
}

}  // namespace
}  // namespace planecast
