// Packs organised float32 clouds losslessly, bit for bit (docs/wire-format.md, "Raw tile"): for
// clouds whose z lies on no integer grid. Encoder half.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/base/arena.hpp"
#include "core/base/status.hpp"
#include "core/cloud/sensor_frame.hpp"
#include "core/wire/frame_pack.hpp"
#include "core/wire/range_encoder.hpp"
#include "core/wire/raw_rays.hpp"
#include "core/wire/raw_syntax.hpp"

namespace planecast {

/// Smallest slice limit of raw clouds: one block of 64 points stored as it is, with its header.
inline constexpr std::size_t kMinRawSliceBytes = 832;

/// Bytes that a raw frame can never exceed, whatever its content.
std::size_t raw_frame_capacity(std::uint32_t width, std::uint32_t height) noexcept;

/// Packs raw clouds of one stream. One thread; memory from the arena at start: about 0.5 MB and
/// 4 bytes a block.
class RawFramePacker {
 public:
  void layout(Arena& arena, std::uint32_t max_width, std::uint32_t max_height) noexcept;

  /// Packs `points` [any unit and frame], row-major, width * height of config.camera, into `out` as
  /// sealed slices of at most `slice_bytes` (kMinRawSliceBytes or more; kFileSliceBytes for files).
  /// A point with a coordinate that is not finite is a hole. `places` receives the slices in order.
  /// kBadConfig: config is not of kRawCloud, or slice_bytes too small; kWrongSize: number of
  /// points; kFrameTooLarge: more than the layout; kTooLarge: `out` (raw_frame_capacity) or
  /// `places` (slice_capacity) is too small. O(points), no allocation.
  Status pack(const StreamConfig& config, std::span<const Point3f> points,
              const FrameIdentity& identity, std::size_t slice_bytes, std::span<std::uint8_t> out,
              std::span<SlicePlace> places, FrameReport& report) noexcept;

  /// The rays found in the frame packed last.
  const RawRays& rays() const noexcept { return rays_; }

 private:
  struct Job;

  void count_readings(const Job& job) noexcept;
  std::uint32_t readings(const Job& job, const TileRect& rect) const noexcept;
  std::uint64_t estimate_bits(const Job& job, const TileRect& rect) const noexcept;
  Status pack_rect(Job& job, const TileRect& rect) noexcept;
  Status pack_halves(Job& job, const TileRect& rect) noexcept;
  Status pack_tile(Job& job, const TileRect& rect, std::span<std::uint8_t> out,
                   std::size_t& bytes) noexcept;

  std::span<RawState> states_;
  std::span<std::uint32_t> sums_;  ///< summed-area table of readings, one more each way
  RawRaysFitter fitter_;
  RawRays rays_;
  RawModels models_;
  std::uint64_t reading_bits_q4_ = 40 * 16;  ///< measured bits of one reading
};

}  // namespace planecast
