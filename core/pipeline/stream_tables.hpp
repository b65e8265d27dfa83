// Everything a half derives from a key packet, in memory taken once: rays, levels, bounds, scale,
// and the models that tiles start from.
#pragma once

#include <cstdint>

#include "core/base/arena.hpp"
#include "core/predict/bound_table.hpp"
#include "core/predict/level_table.hpp"
#include "core/regen/regenerate.hpp"
#include "core/wire/residual_models.hpp"
#include "core/wire/tile_syntax.hpp"

namespace planecast {

struct PointSurfaceOptions;

/// Largest frame a pipeline is laid out for, and what else memory follows from.
struct FrameLimits {
  std::uint16_t max_width = 640;
  std::uint16_t max_height = 480;
  std::uint32_t max_points = 0;  ///< of a list of points; 0: streams of lists are refused
  // Encoders of lists only (list_limits()):
  std::size_t list_bytes = 0;                     ///< of a frame's slices at most
  std::size_t list_slices = 0;                    ///< at most
  const PointSurfaceOptions* surfaces = nullptr;  ///< how surfaces or outliers are found; null: not

  std::uint32_t pixels() const noexcept { return std::uint32_t{max_width} * max_height; }
};

/// Tables of the current key packet. build() is O(pixels) for a camera with distortion and about
/// 10 ms otherwise, and once as much or more to unpack the models that tiles start from: it runs
/// when a key changes, not once a frame. Read-only between builds.
class StreamTables {
 public:
  void layout(Arena& arena, const FrameLimits& limits,
              CodecHalf half = CodecHalf::kEncoder) noexcept;

  /// kFrameTooLarge: larger than the limits; kFieldRange: as check_config and build_ray_table say.
  /// What is refused by its numbers alone leaves the current tables in use; a camera whose
  /// distortion cannot be undone, or a lattice out of range, leaves none.
  Status build(const StreamConfig& config, std::uint32_t key_hash) noexcept;

  bool ready() const noexcept { return ready_; }
  std::uint32_t key_hash() const noexcept { return key_hash_; }
  const StreamConfig& config() const noexcept { return config_; }
  const RayTable& rays() const noexcept { return rays_; }
  const LevelTable& levels() const noexcept { return levels_; }
  const BoundTable& bounds() const noexcept { return bounds_; }
  const DepthScale& scale() const noexcept { return scale_; }
  CodingTables coding() const noexcept {
    return {&config_, &rays_, &levels_, &bounds_, residuals_.data()};
  }

 private:
  FrameLimits limits_;
  bool ready_ = false;
  std::uint32_t key_hash_ = 0;
  StreamConfig config_;
  std::span<std::int32_t> ray_storage_;
  RayTable rays_;
  LevelTable levels_;
  BoundTable bounds_;
  DepthScale scale_;
  std::span<ResidualModels> residuals_;  ///< one set
  int residual_set_ = -1;                ///< which one: 1 of every count, -1 none yet
};

}  // namespace planecast
