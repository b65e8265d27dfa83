// Which blocks are coded by which surface: by an estimate of the bits that the coder will spend
// with the surface and without, so that a surface never costs more than it saves.
#pragma once

#include <cstdint>
#include <span>

#include "core/base/arena.hpp"
#include "core/fit/fit_tables.hpp"
#include "core/model/frame_model.hpp"
#include "core/model/region_map.hpp"

namespace planecast {

/// Surfaces of the regions around a block: at most four different ones of its 3 x 3 cells.
struct Candidates {
  std::uint8_t label[4] = {};
  int count = 0;
};

/// Candidates of block (bx, by), own cell first; `surface_of[k]`: label of region k's surface, 0
/// when it has none.
Candidates block_candidates(const RegionMap& regions, std::span<const std::uint8_t> surface_of,
                            std::uint32_t bx, std::uint32_t by) noexcept;

/// Labels blocks by cost. One thread. Memory: 16 bytes a column and 8 a block.
class BlockLabeller {
 public:
  void layout(Arena& arena, std::uint32_t max_width, std::uint32_t max_height) noexcept;

  /// Fills labels (blocks row-major) with 0 or 1 + index into `surfaces`. Sizes were checked by the
  /// caller. Surfaces that save less than they cost lose all their blocks. About 0.7 ms for
  /// 640 x 480: two rows of every block are looked at.
  void process(const FitTables& tables, std::span<const std::uint16_t> depth,
               const RegionMap& regions, std::span<const std::uint8_t> surface_of,
               std::span<const Surface> surfaces, std::span<BlockLabel> labels) noexcept;

 private:
  /// The surface a block gains most by, and how many bits.
  struct Offer {
    float gain = 0;
    std::uint8_t label = 0;
    bool flat = false;  ///< the block is flat without a surface, too
  };

  void load_levels(const FitTables& tables, std::span<const std::uint16_t> depth,
                   std::uint32_t by) noexcept;

  Offer offer_of(const FitTables& tables, const RegionMap& regions,
                 std::span<const std::uint8_t> surface_of, std::span<const Surface> surfaces,
                 std::uint32_t bx, std::uint32_t by) const noexcept;
  Offer best_offer(const FitTables& tables, const Candidates& candidates,
                   std::span<const Surface> surfaces, std::uint32_t bx,
                   std::uint32_t by) const noexcept;
  void choose(const RegionMap& regions, float own_say, float least,
              std::span<const Surface> surfaces, std::span<BlockLabel> labels) noexcept;

  std::span<Offer> offers_;  ///< of each block
  std::span<float> levels_;  ///< of the sampled rows of a row of blocks, with borders of holes
  std::size_t stride_ = 0;
};

}  // namespace planecast
