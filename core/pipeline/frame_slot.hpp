// What one frame in flight owns, stage by stage: carved once from the arena, never moved.
#pragma once

#include <cstdint>
#include <span>

#include "core/base/arena.hpp"
#include "core/model/frame_model.hpp"
#include "core/model/grid_point.hpp"
#include "core/model/region_map.hpp"
#include "core/pipeline/frame_budget.hpp"
#include "core/pipeline/point_surfaces.hpp"
#include "core/pipeline/stream_tables.hpp"
#include "core/wire/frame_pack.hpp"

namespace planecast {

/// Points of a frame by what became of them; every reading of the input is in exactly one of
/// out_of_range, outliers_dropped, off_surface_dropped and kept.
struct PointCounts {
  std::uint32_t input = 0;  ///< readings in the frame as submitted
  std::uint32_t out_of_range = 0;
  std::uint32_t outliers = 0;  ///< flagged, which happens only when they are dropped
  std::uint32_t outliers_dropped = 0;
  std::uint32_t on_surface = 0;           ///< surfaces contract: within the bound of a surface
  std::uint32_t off_surface = 0;          ///< surfaces contract: the rest
  std::uint32_t off_surface_dropped = 0;  ///< of off_surface, when asked
  std::uint32_t kept = 0;
};

/// What becomes of a point of a list.
enum class PointFate : std::uint8_t {
  kCoded = 0,      ///< travels as itself
  kOutlier = 1,    ///< dropped
  kOnSurface = 2,  ///< a patch brings back one in its place
  kOffSurface = 3  ///< dropped
};

/// One slot. Fields are written by the stage named and read by later ones.
struct FrameSlot {
  // source
  std::uint64_t number = 0;
  std::int64_t stamp_ns = 0;
  std::int64_t submitted_ns = 0;   ///< monotonic clock, frame in memory
  std::span<std::uint16_t> depth;  ///< source; filter, fit and drop modes clear readings
  std::span<Point3f> points;  ///< raw clouds; lists: the first `listed`, out of range taken out
  std::uint32_t listed = 0;   ///< lists: source; filter
  // filter
  std::span<std::uint8_t> outliers;  ///< 1: flagged
  std::span<std::uint8_t> fates;     ///< lists: PointFate of each; filter, fit
  PointCounts counts;
  FrameEffort effort = FrameEffort::kFull;  ///< what the time allowed; stages may lower it
  std::int64_t spent_ns = 0;                ///< by stages that watch a budget
  // segment
  std::span<Cell> cells;
  std::span<std::uint8_t> cell_labels;
  RegionMap regions;
  // fit
  std::span<BlockLabel> blocks;
  std::span<Surface> surfaces;
  std::uint32_t surface_count = 0;
  std::uint8_t shift = 0;
  std::span<GridPoint> grid;  ///< lists: the first `on_grid` are to be coded as themselves
  std::uint32_t on_grid = 0;
  PointSurfaces list_surfaces;  ///< lists: filter, segment and fit go on with what the last left
  bool seeks = false;           ///< whether list_surfaces has memory
  // pack
  std::span<std::uint8_t> packed;
  std::span<SlicePlace> places;
  FrameReport report;
  std::int64_t packed_ns = 0;  ///< monotonic clock, bytes ready

  /// Takes the slot's memory.
  void layout(Arena& arena, const FrameLimits& limits, FrameKind kind) noexcept;

  /// Starts a new frame: nothing is left of the slot's last one, should this one skip its stages.
  void begin(std::uint64_t frame, std::int64_t captured_ns, std::int64_t now_ns) noexcept {
    number = frame;
    stamp_ns = captured_ns;
    submitted_ns = now_ns;
    listed = 0;
    on_grid = 0;
    counts = {};
    effort = FrameEffort::kFull;
    spent_ns = 0;
    regions = {};
    surface_count = 0;
    shift = 0;
    report = {};
    packed_ns = 0;
  }

  FrameModel model() const noexcept {
    return {depth, blocks, surfaces.first(surface_count), shift};
  }
  std::span<const std::uint8_t> slice(std::uint32_t i) const noexcept {
    return packed.subspan(places[i].offset, places[i].bytes);
  }

 private:
  void layout_list(Arena& arena, const FrameLimits& limits) noexcept;
};

}  // namespace planecast
