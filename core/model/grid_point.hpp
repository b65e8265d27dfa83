// A point on a stream's integer grid, and what both halves of the point codec derive from the key
// packet about it (docs/wire-format.md, "Point tile").
#pragma once

#include <cstdint>

namespace planecast {

/// A point in steps of the stream's grid, relative to the stream's origin: the coordinate that
/// comes out is float(i * step). In lossless streams of float bits, an ordered bit pattern.
struct GridPoint {
  std::int32_t x = 0;
  std::int32_t y = 0;
  std::int32_t z = 0;

  friend bool operator==(const GridPoint&, const GridPoint&) = default;
};

/// Largest tolerance of a point stream [grid steps].
inline constexpr std::uint32_t kMaxPointTolerance = 1U << 20U;

/// What the key packet says about coding unorganised points.
struct PointCoding {
  /// Bound between the points that go in and those that come out, both ways, Euclidean
  /// [grid steps], 0 .. kMaxPointTolerance. 0: every point comes back as it is. A grid about a
  /// hundredth of the bound loses nothing worth naming.
  std::uint32_t tolerance = 0;
  /// Points of the largest frame; a frame that claims more is refused.
  std::uint32_t max_points = 0;

  bool lossless() const noexcept { return tolerance == 0; }
  friend bool operator==(const PointCoding&, const PointCoding&) = default;
};

/// First two bits of the body of each slice of a point stream: what the slice holds.
enum class PointSliceKind : std::uint8_t {
  kVerbatim = 0,  ///< cells of points as plain numbers
  kCoded = 1,     ///< a tree of cells
  kPatches = 2,   ///< surfaces with their boundaries
};

}  // namespace planecast
