// Decodes the slices of a raw cloud: the mirror of raw_pack.hpp, for bytes from anywhere. Decoder
// half: every field is bounded before it is believed, nothing is allocated.
#pragma once

#include <cstdint>
#include <span>

#include "core/base/arena.hpp"
#include "core/base/status.hpp"
#include "core/cloud/sensor_frame.hpp"
#include "core/model/stream_config.hpp"
#include "core/wire/raw_syntax.hpp"
#include "core/wire/tile_unpack.hpp"

namespace planecast {

/// Makes every point a hole; call before the slices of a frame, since some may never come.
void clear_points(std::span<Point3f> points) noexcept;

/// Decodes raw slices one by one, in any order. One thread; memory from the arena at start.
class RawFrameUnpacker {
 public:
  void layout(Arena& arena, std::uint32_t max_width) noexcept;

  /// Decodes one sealed slice into `target` (row-major, width * height of config.camera). Time is
  /// bounded by the tile's points. Holes become NaN, NaN, NaN. kUnknownKey: coded under another key
  /// packet; kBadConfig: config is not of kRawCloud; kWrongSize: target's size; kTooLarge: wider
  /// than the layout; those of open_packet; kFieldRange: a rectangle outside the image or rays
  /// that no encoder writes; kBadSymbol: an impossible residual; kTruncated; kTrailingBytes. On
  /// failure the tile's rectangle, where it was known, holds holes.
  Status unpack_slice(const StreamConfig& config, std::uint32_t key_hash,
                      std::span<const std::uint8_t> packet, std::span<Point3f> target,
                      TileContent& content) noexcept;

 private:
  std::span<RawState> states_;
  RawModels models_;
};

}  // namespace planecast
