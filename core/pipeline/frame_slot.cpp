#include "core/pipeline/frame_slot.hpp"

#include "core/wire/raw_pack.hpp"

namespace planecast {

void FrameSlot::layout_list(Arena& arena, const FrameLimits& limits) noexcept {
  const std::uint32_t most = limits.max_points;
  points = arena.take<Point3f>(most);
  fates = arena.take<std::uint8_t>(most);
  grid = arena.take<GridPoint>(most);
  seeks = limits.surfaces != nullptr;
  if (seeks) list_surfaces.layout(arena, most, *limits.surfaces);
  packed = arena.take<std::uint8_t>(limits.list_bytes);
  places = arena.take<SlicePlace>(limits.list_slices);
}

void FrameSlot::layout(Arena& arena, const FrameLimits& limits, FrameKind kind) noexcept {
  if (kind == FrameKind::kPoints) {
    layout_list(arena, limits);
    return;
  }
  const std::size_t pixels = limits.pixels();
  const std::size_t blocks_in_frame =
      std::size_t{(limits.max_width + 7U) / 8} * ((limits.max_height + 7U) / 8);
  std::size_t bytes = frame_capacity(limits.max_width, limits.max_height);
  if (kind == FrameKind::kRawCloud) {
    points = arena.take<Point3f>(pixels);
    bytes = raw_frame_capacity(limits.max_width, limits.max_height);
  } else {
    depth = arena.take<std::uint16_t>(pixels);
    outliers = arena.take<std::uint8_t>(pixels);
    cells = arena.take<Cell>(blocks_in_frame);
    cell_labels = arena.take<std::uint8_t>(blocks_in_frame);
    blocks = arena.take<BlockLabel>(blocks_in_frame);
    surfaces = arena.take<Surface>(kMaxSurfaces);
  }
  packed = arena.take<std::uint8_t>(bytes);
  places = arena.take<SlicePlace>(slice_capacity(limits.max_width, limits.max_height));
}

}  // namespace planecast
