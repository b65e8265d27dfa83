// Depth grids of float clouds: many "float" clouds are a 16-bit depth image times a unit. Where the
// file proves it, bit for bit, the codec keeps the 16-bit counts and gives the same floats back.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/cloud/sensor_frame.hpp"

namespace planecast {

/// The grid: count k = 1..65535 stands for one float32.
struct ZGrid {
  enum class Rule : std::uint8_t {
    kDoubleProduct = 0,  ///< float(k * unit), unit and product in double
    kFloatProduct = 1,   ///< float(k) * float(unit), in float
    kPrinted7 = 2,       ///< the float product, printed with 7 significant digits and read back
  };

  std::uint64_t unit_pm = 0;  ///< [pm], 10^9 = 1 mm
  Rule rule = Rule::kDoubleProduct;

  friend bool operator==(const ZGrid&, const ZGrid&) = default;
};

/// The float32 z [m] of a count. IEEE double and float + * / only: the same on every machine.
float grid_z(const ZGrid& grid, std::uint16_t count) noexcept;

/// The count whose grid_z is exactly z, or 0 when there is none (also for NaN, 0, negative z).
std::uint16_t grid_count(const ZGrid& grid, float z) noexcept;

/// A grid's floats, all at hand to count many readings by.
class ZGridTable {
 public:
  /// 256 kB, and as many grid_z() as there are counts.
  explicit ZGridTable(const ZGrid& grid);

  /// grid_z() of a count [m], 1..65535; of 0, zero. O(1), and any thread's.
  float z(std::int32_t count) const noexcept { return z_[static_cast<std::size_t>(count)]; }

 private:
  std::vector<float> z_;  ///< of each count [m]
};

/// The coarsest known grid on which every valid z of the cloud lies exactly, or nothing (also for a
/// cloud without valid points). Tries 1, 0.5, 0.25, 0.2, 0.125 and 0.1 mm. Cold path; O(points).
std::optional<ZGrid> find_z_grid(const PointCloud& cloud) noexcept;

}  // namespace planecast
