// Splits a depth image into planar regions: seeded growing over cells from the flattest one, then
// regions that one plane explains are joined. Deterministic; no allocation after layout().
#pragma once

#include <cstdint>
#include <span>

#include "core/base/arena.hpp"
#include "core/base/status.hpp"
#include "core/model/region_map.hpp"
#include "core/segment/cell_grid.hpp"

namespace planecast {

/// Thresholds, as root-mean-square residuals of a cell in noise sigmas (or levels, see
/// InverseNoise).
struct GrowingOptions {
  double seed_sigmas = 2.0;     ///< a seed's residual from its own plane
  double accept_sigmas = 3.0;   ///< a cell's residual from the region's surface
  std::uint32_t min_cells = 4;  ///< smaller regions are given up
  bool curved = true;           ///< regions may be of degree two
};

/// Region growing over the cells of one frame. One thread. Memory: 11 bytes a cell and 280 KiB.
class RegionGrowing {
 public:
  void layout(Arena& arena, std::uint32_t max_width, std::uint32_t max_height) noexcept;

  /// Fills `out` (labels: this object's memory, valid until the next call) with at most
  /// kMaxSurfaces regions, the largest. O(cells). kFrameTooLarge: more cells than the layout.
  Status process(const CellGrid& grid, const GrowingOptions& options, RegionMap& out) noexcept;

 private:
  struct Region {
    PlaneSums sums;
    FloatSurface surface;
    double readings = 0;
    double squares = 0;  ///< sum of squared residuals of its readings, in noise variances
    std::uint32_t cells = 0;
    std::uint16_t final_label = 0;
    std::uint16_t kept_sums = 0;  ///< 1 + place of its cells' sums in grown_; 0: not kept
    Region* joined = nullptr;  ///< the region that took this one in
  };
  struct Adjacency;

  void order_seeds(const CellGrid& grid, double threshold) noexcept;
  void grow(const CellGrid& grid, std::uint32_t seed, const GrowingOptions& options) noexcept;
  std::uint32_t spread(const CellGrid& grid, Region& region, std::uint32_t head, std::uint32_t tail,
                       float accept, bool refit) noexcept;
  void keep_sums(Region& region, const QuadricSums& sums) noexcept;
  void try_curved(const CellGrid& grid, Region& region, const GrowingOptions& options) noexcept;
  void keep_largest() noexcept;
  void merge(const CellGrid& grid, const GrowingOptions& options) noexcept;
  void sum_quadrics(const CellGrid& grid) noexcept;
  bool merge_planes(Region& first, Region& second, bool touch) noexcept;
  bool merge_curved(Region& first, Region& second) noexcept;
  static void prefer_plane(Region& region) noexcept;
  static Region* root(Region* region) noexcept;
  void number_again() noexcept;

  std::span<std::uint32_t> order_;
  std::span<std::uint32_t> queue_;
  std::span<std::uint16_t> mark_;  ///< 0 free, kGivenUp, else 1 + index into regions_
  std::span<std::uint8_t> labels_;
  std::span<Region> regions_;
  std::span<QuadricSums> quadrics_;  ///< of the kept regions, by label
  std::span<QuadricSums> grown_;     ///< of the first regions that degree two was tried on
  std::uint16_t grown_count_ = 0;
  std::uint32_t seeds_ = 0;
  std::uint32_t region_count_ = 0;
};

/// Cells and regions of a frame in one call.
class Segmenter {
 public:
  void layout(Arena& arena, std::uint32_t max_width, std::uint32_t max_height) noexcept {
    grid_.layout(arena, max_width, max_height);
    growing_.layout(arena, max_width, max_height);
  }

  /// Segments `depth` (row-major counts, 0 = no reading). `out` points into this object until the
  /// next call. kWrongSize, kFrameTooLarge as CellGrid::process. About 1 ms for 640 x 480.
  Status process(const StreamConfig& config, const RayTable& rays,
                 std::span<const std::uint16_t> depth, RegionMap& out,
                 const GrowingOptions& options = {}) noexcept {
    const Status status = grid_.process(config, rays, depth);
    if (status != Status::kOk) {
      out = {};
      return status;
    }
    return growing_.process(grid_, options, out);
  }

 private:
  CellGrid grid_;
  RegionGrowing growing_;
};

}  // namespace planecast
