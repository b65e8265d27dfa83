// What the four stages do with a list of points.
#pragma once

#include "core/base/arena.hpp"
#include "core/pipeline/frame_slot.hpp"
#include "core/pipeline/stage_options.hpp"
#include "core/wire/patch_pack.hpp"
#include "core/wire/point_pack.hpp"

namespace planecast {

/// Whether a stream's lists are searched for surfaces, which become patches.
bool seeks_surfaces(const StreamConfig& config, const StageOptions& options) noexcept;

/// How surfaces and outliers of a stream's lists are found.
PointSurfaceOptions surface_options(const StreamConfig& config,
                                    const StageOptions& options) noexcept;

/// What memory of a stream of lists follows from. `search` is surface_options() of the same stream
/// and must outlive the layout that the limits are for.
FrameLimits list_limits(const StreamConfig& config, const StageOptions& options,
                        const PointSurfaceOptions& search) noexcept;

/// Takes out points that are not finite or out of range; finds outliers where they are to be
/// dropped or surfaces are sought.
Status filter_list(const StreamConfig& config, const StageOptions& options,
                   FrameSlot& slot) noexcept;

/// Regions, where surfaces are sought.
Status segment_list(const StreamConfig& config, const StageOptions& options,
                    FrameSlot& slot) noexcept;

/// Surfaces with their boundaries, where they are sought; says what becomes of each point and
/// rounds what is coded as itself to the stream's grid.
Status fit_list(const StreamConfig& config, const StageOptions& options, FrameSlot& slot) noexcept;

/// Slices of patches first, then those of points, sealed.
class ListPack {
 public:
  void layout(Arena& arena, const FrameLimits& limits) noexcept;
  Status process(const StreamTables& tables, const StageOptions& options,
                 const FrameIdentity& identity, FrameSlot& slot) noexcept;

 private:
  PatchPacker patches_;
  PointFramePacker points_;
};

}  // namespace planecast
