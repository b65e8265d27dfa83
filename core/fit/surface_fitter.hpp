// From regions to what the packer codes: surfaces as integers and a label for every block. The one
// entry of this room for the pipeline's fit stage.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "core/base/arena.hpp"
#include "core/base/status.hpp"
#include "core/fit/block_label.hpp"
#include "core/fit/consensus.hpp"
#include "core/fit/fit_tables.hpp"
#include "core/fit/region_refine.hpp"
#include "core/model/frame_model.hpp"
#include "core/model/region_map.hpp"

namespace planecast {

/// What fitting a frame found.
struct FitReport {
  std::uint32_t surfaces = 0;       ///< entries of the caller's `surfaces` in use
  std::uint8_t shift = 0;           ///< coefficients are multiples of 2^shift
  std::uint32_t split_regions = 0;  ///< regions that consensus took apart
  std::uint32_t labelled_blocks = 0;
};

/// Fits surfaces and labels blocks. One thread; deterministic. Memory: 8 bytes a pixel at most.
class SurfaceFitter {
 public:
  /// Takes memory for frames of up to max_width x max_height pixels; call while starting.
  void layout(Arena& arena, std::uint32_t max_width, std::uint32_t max_height) noexcept;

  /// `depth`: row-major counts, 0 = no reading. `regions`: of this very depth; split regions are
  /// relabelled in place. `labels`: one for each block, row-major. `surfaces`: kMaxSurfaces long;
  /// only surfaces that some block uses are kept, so report.surfaces may be less than the regions.
  /// Streams of surfaces kind are labelled by label_on_surface, all others by cost. kWrongSize:
  /// spans and tables disagree; kFrameTooLarge: beyond the layout. O(pixels), no allocation, about
  /// 2 ms for 640 x 480.
  Status fit(const FitTables& tables, std::span<const std::uint16_t> depth, RegionMap& regions,
             std::span<BlockLabel> labels, std::span<Surface> surfaces, FitReport& report,
             const ConsensusOptions& options = {}) noexcept;

  /// Regions and fits of the last frame of a surfaces stream, over fine cells.
  const RegionMap& refined() const noexcept { return refined_; }
  std::span<const RegionFit> fits() const noexcept { return fits_; }

 private:
  static void keep_used(std::span<BlockLabel> labels, std::span<Surface> surfaces,
                        FitReport& report) noexcept;

  BlockLabeller labeller_;
  RegionRefiner refiner_;
  RegionMap refined_;
  std::array<RegionFit, kMaxSurfaces> fits_{};
  std::span<std::uint32_t> scratch_;
  std::span<std::uint64_t> off_;
};

}  // namespace planecast
