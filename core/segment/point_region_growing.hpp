// Regions of smooth surface in unorganised clouds: grown from the point of least curvature over
// neighbours whose normals differ little (the paper's Algorithm 1; Rabbani et al. 2006).
#pragma once

#include <cstdint>
#include <limits>
#include <span>

#include "core/base/arena.hpp"
#include "core/base/status.hpp"
#include "core/segment/point_normals.hpp"

namespace planecast {

/// Which points of a region go on to be seeds themselves.
enum class CurvatureTest : std::uint8_t {
  kDifference = 0,  ///< curvature differs from the seed's by at most the limit (the paper)
  kAbsolute = 1,    ///< curvature is at most the limit (PCL)
};

struct PointRegionOptions {
  double smoothness_deg = 3.0;  ///< most angle between the normals of seed and neighbour, 0..90
  CurvatureTest test = CurvatureTest::kDifference;
  double curvature_limit = 0.05;  ///< 1 lets every point pass
  std::uint32_t min_points = 50;  ///< regions of fewer are given up; their points have none
};

/// Region of points that are in none.
inline constexpr std::uint32_t kNoRegion = std::numeric_limits<std::uint32_t>::max();

/// What growing gave.
struct PointRegionReport {
  std::uint32_t regions = 0;   ///< kept, numbered from 0 in the order of their seeds
  std::uint32_t clusters = 0;  ///< grown, those too small included (the paper's TC)
  std::uint32_t points = 0;    ///< in the regions kept
  double intra_distance = 0;   ///< mean distance of neighbours in one region [m]
  double inter_distance = 0;   ///< mean distance of neighbours in two different regions [m]
};

/// Grows regions. One thread; memory (8 bytes a point) from the arena at start.
class PointRegionGrowing {
 public:
  void layout(Arena& arena, std::uint32_t max_points) noexcept;

  /// Writes the region of every point of `cloud`, in search order, to `regions`. Seeds are taken in
  /// rising order of curvature until none is left. Points without a normal (removed ones) are in no
  /// region. kWrongSize; kFrameTooLarge: beyond the layout; kBadConfig: an option out of its range.
  /// O(n k), no allocation.
  Status grow(const PointNeighbours& cloud, const PointNormals& normals,
              const PointRegionOptions& options, std::span<std::uint32_t> regions,
              PointRegionReport& report) noexcept;

 private:
  void sort_by_curvature(std::span<const float> curvature) noexcept;

  std::span<std::uint32_t> seeds_;  ///< points by curvature
  std::span<std::uint32_t> queue_;  ///< points of the region being grown
};

}  // namespace planecast
