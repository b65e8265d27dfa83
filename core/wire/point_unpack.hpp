// Decodes the slices of a stream of unorganised points: the mirror of point_pack.hpp, for bytes
// from anywhere. Decoder half: every field is bounded before it is believed, nothing is allocated.
#pragma once

#include <cstdint>
#include <span>

#include "core/base/arena.hpp"
#include "core/base/status.hpp"
#include "core/model/grid_point.hpp"
#include "core/wire/point_levels.hpp"
#include "core/wire/point_models.hpp"

namespace planecast {

/// What the first bits of a sealed slice's body say it holds. `packet` has a header and one byte
/// more, else kTruncated; kFieldRange: the reserved kind.
Status point_slice_kind(std::span<const std::uint8_t> packet, PointSliceKind& kind) noexcept;

/// Decodes point slices one by one, in any order. One thread; memory from the arena at start.
class PointFrameUnpacker {
 public:
  void layout(Arena& arena, std::uint32_t max_points) noexcept;

  /// Decodes one sealed slice of kind kVerbatim or kCoded and writes its points to
  /// target[used ...], raising `used`; `target` holds the frame's points, at least
  /// coding.max_points. Time and memory are bounded by max_points. kUnknownKey: coded under another
  /// key packet; kBadConfig: tolerance out of range; those of open_packet; kFieldRange: another
  /// kind, or a field out of its range; kTooLarge: more points than the frame may still have;
  /// kBadSymbol: an impossible value; kTruncated; kTrailingBytes. On failure `used` stays.
  Status unpack_slice(const PointCoding& coding, std::uint32_t key_hash,
                      std::span<const std::uint8_t> packet, std::span<GridPoint> target,
                      std::uint32_t& used) noexcept;

 private:
  template <class Io>
  Status unpack_tree(Io& io) noexcept;

  PointLevels levels_;
  std::span<PointModels> models_;  ///< one
  PointMixers mixers_;
};

}  // namespace planecast
