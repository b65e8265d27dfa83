#include "core/pipeline/stream_tables.hpp"

namespace planecast {

void StreamTables::layout(Arena& arena, const FrameLimits& limits, CodecHalf half) noexcept {
  limits_ = limits;
  ray_storage_ = arena.take<std::int32_t>(std::size_t{limits.pixels()} * 2 + 2);
  levels_.layout(arena);
  bounds_.layout(arena, limits.pixels(), half);
  scale_.layout(arena);
}

Status StreamTables::build(const StreamConfig& config, std::uint32_t key_hash) noexcept {
  if (const Status status = check_config(config); status != Status::kOk) return status;
  if (config.camera.width > limits_.max_width || config.camera.height > limits_.max_height ||
      config.points.max_points > limits_.max_points) {
    return Status::kFrameTooLarge;
  }
  ready_ = false;
  config_ = config;
  key_hash_ = key_hash;
  if (config.kind == FrameKind::kPoints) {  // no rays, no levels
    ready_ = true;
    return Status::kOk;
  }
  Status status = build_ray_table(config_.camera, ray_storage_, rays_);
  if (status != Status::kOk) return status;
  status = levels_.build(config_.lattice);
  if (status != Status::kOk) return status;
  status = bounds_.build(config_, rays_, levels_);
  if (status != Status::kOk) return status;
  scale_.build(config_);
  ready_ = true;
  return Status::kOk;
}

}  // namespace planecast
