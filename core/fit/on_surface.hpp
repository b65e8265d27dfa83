// The surfaces contract: which readings lie on a surface within the bound, which blocks hold them,
// and dropping what lies on none.
#pragma once

#include <cstdint>
#include <span>

#include "core/fit/block_label.hpp"
#include "core/fit/fit_tables.hpp"
#include "core/model/frame_model.hpp"

namespace planecast {

/// Labels blocks of a stream of ToleranceKind::kSurfaces: first = the surface that most readings
/// lie on, when that is at least a quarter of them; second = the one that explains most of the
/// rest, when those are at least six, or ten where the rest is dropped. `regions`: over fine cells;
/// surfaces of cells in and around a block are tried, then those of its neighbours, also where it
/// has none and half of its readings lie on one. `off`, one for each block: its readings on
/// neither, one bit each. O(pixels), about 1.5 ms for 640 x 480. Sizes were checked by the caller.
void label_on_surface(const FitTables& tables, std::span<const std::uint16_t> depth,
                      const RegionMap& regions, std::span<const std::uint8_t> surface_of,
                      std::span<const Surface> surfaces, std::span<BlockLabel> labels,
                      std::span<std::uint64_t> off) noexcept;

/// Readings on and off the surfaces of their blocks.
struct SurfaceCounts {
  std::uint32_t on = 0;
  std::uint32_t off = 0;
};

/// Counts readings on one of their block's surfaces within the bound, by the decoder's own
/// arithmetic; with `drop`, those on none become holes (and are the ones counted off). kWrongSize:
/// spans and tables disagree.
Status drop_off_surface(const FitTables& tables, std::span<std::uint16_t> depth,
                        std::span<const Surface> surfaces, std::span<const BlockLabel> labels,
                        bool drop, SurfaceCounts& counts) noexcept;

}  // namespace planecast
