// The regions of a surfaces stream over cells of 4 x 4 pixels: their borders follow what fits best,
// faces that are too narrow for the segmentation's cells are found, and no face counts twice.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "core/base/arena.hpp"
#include "core/fit/fine_cells.hpp"
#include "core/fit/plane_fit.hpp"

namespace planecast {

/// Residual, in noise variances, up to which a cell of a refined region counts for its fit.
inline constexpr float kCleanResidual = 4;

/// Refines regions. One thread; deterministic. Memory: 57 bytes a fine cell.
class RegionRefiner {
 public:
  void layout(Arena& arena, std::uint32_t max_width, std::uint32_t max_height) noexcept;

  /// `coarse`: regions of this very depth over cells of 8 x 8, fitted in `fits` (kMaxSurfaces
  /// long). Returns regions over fine cells (this object's memory, until the next call) and their
  /// fits in `fits`; regions that lost all cells are not valid there. Sizes were checked by the
  /// caller. O(cells); no allocation; about 2.5 ms for 640 x 480.
  const RegionMap& process(const FitTables& tables, std::span<const std::uint16_t> depth,
                           const RegionMap& coarse, std::span<RegionFit> fits) noexcept;

  /// Joins planes of which the smaller one's readings lie on the larger one's surface nearly as
  /// well as on its own, once `fits` (of the last process()) were changed: planes that were turned
  /// alike often are one. The larger one's surface stays. O(cells + regions^2).
  void join_same(std::span<RegionFit> fits) noexcept;

 private:
  /// Different labels other than 0.
  struct LabelSet {
    std::uint8_t label[16] = {};
    int count = 0;

    void add(std::uint8_t next) noexcept {
      if (next == 0) return;
      for (int i = 0; i < count; ++i) {
        if (label[i] == next) return;
      }
      label[count++] = next;
    }
  };

  /// A region of degree one as join() weighs it; no readings: not to be joined.
  struct JoinPlane {
    PlaneSums sums;
    double readings = 0, squares = 0;
  };
  using Planes = std::array<JoinPlane, kMaxSurfaces + 1>;

  LabelSet labels_around(std::uint32_t x, std::uint32_t y) const noexcept;
  void leave_rest(const FitTables& tables, std::span<const std::uint16_t> depth,
                  std::span<const RegionFit> fits) noexcept;
  void inherit(const RegionMap& coarse) noexcept;
  void fit(std::span<RegionFit> fits) const noexcept;
  void settle(std::span<const RegionFit> fits) noexcept;
  std::uint8_t best_label(std::uint32_t x, std::uint32_t y,
                          std::span<const RegionFit> fits) const noexcept;
  bool seed_plane(std::uint32_t x, std::uint32_t y, float limit,
                  FloatSurface& plane) const noexcept;
  std::uint32_t grow(std::uint32_t seed, FloatSurface& plane, std::uint8_t label) noexcept;
  void discover(std::uint32_t least_cells, std::span<RegionFit> fits) noexcept;
  void discover(std::uint32_t least_cells, float limit, std::span<RegionFit> fits) noexcept;
  Planes sum_planes(std::span<const RegionFit> fits) const noexcept;
  void join(std::span<RegionFit> fits) noexcept;
  bool is_inside(std::uint32_t x, std::uint32_t y) const noexcept;

  std::span<Cell> cells_;
  std::span<std::uint8_t> labels_;
  std::span<std::uint32_t> queue_;
  RegionMap map_;
};

}  // namespace planecast
