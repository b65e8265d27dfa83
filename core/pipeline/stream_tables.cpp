#include "core/pipeline/stream_tables.hpp"

#include "core/wire/mix_models.hpp"
#include "core/wire/point_models.hpp"

namespace planecast {

void StreamTables::layout(Arena& arena, const FrameLimits& limits, CodecHalf half) noexcept {
  limits_ = limits;
  ray_storage_ = arena.take<std::int32_t>(std::size_t{limits.pixels()} * 2 + 2);
  levels_.layout(arena);
  bounds_.layout(arena, limits.pixels(), half);
  scale_.layout(arena);
  residuals_ = arena.take<ResidualModels>(1);
  residual_set_ = -1;
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
    trained_point_models();                 // unpacked here, not by the first frame
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
  // Models that tiles start from are unpacked here, not by the first frame.
  if (const int set = levels_.every_count() ? 1 : 0; bounds_.lossless() && set != residual_set_) {
    unpack_residuals(levels_.every_count(), residuals_[0]);
    residual_set_ = set;
  }
  trained_models(bounds_.lossless());
  if (config_.effort_best) trained_mix_models(bounds_.lossless());
  ready_ = true;
  return Status::kOk;
}

}  // namespace planecast
