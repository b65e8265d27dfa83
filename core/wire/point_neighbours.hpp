// What a node of the point tree knows of its 26 neighbours: sums over a 3 x 3 x 3 pattern by
// three table reads, and a plane through the occupied ones. Shared by both halves; integers only
// (docs/wire-format.md, "Point tile").
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

namespace planecast {

/// Position (dx, dy, dz), each -1 .. 1, in a pattern of 27 bits.
constexpr unsigned pattern_bit(int dx, int dy, int dz) noexcept {
  return static_cast<unsigned>((dx + 1) + 3 * (dy + 1) + 9 * (dz + 1));
}
inline constexpr unsigned kCentreBit = pattern_bit(0, 0, 0);

namespace detail {

/// Sums over the set bits of one 3 x 3 layer.
struct LayerSums {
  std::int8_t n, x, y, xx, yy, xy;
};

/// Computed when the program starts, in point_tables.cpp.
extern const std::array<LayerSums, 512> kLayerSums;

}  // namespace detail

/// A plane through the middles of a node and its neighbours, as seen from the node's children.
struct NodePlane {
  std::uint8_t kind = 4;  ///< crowd * 5 + flatness; flatness 4: no plane
  /// Distance of each child's middle in tenths of a child, by the L1 normal, 0 .. 15.
  std::array<std::uint8_t, 8> distance{};
};

/// The plane of a node whose neighbours are `pattern` (its own bit is set). Exact integers.
inline NodePlane node_plane(std::uint32_t pattern) noexcept {
  const auto& below = detail::kLayerSums[pattern & 511U];
  const auto& level = detail::kLayerSums[pattern >> 9U & 511U];
  const auto& above = detail::kLayerSums[pattern >> 18U & 511U];
  const std::int32_t n = below.n + level.n + above.n;
  const std::int32_t x = below.x + level.x + above.x, y = below.y + level.y + above.y;
  const std::int32_t z = above.n - below.n;
  // Covariances times n^2, and the adjugate of their matrix: its columns lean to the normal.
  const std::int64_t cxx = n * (below.xx + level.xx + above.xx) - x * x;
  const std::int64_t cyy = n * (below.yy + level.yy + above.yy) - y * y;
  const std::int64_t czz = n * (below.n + above.n) - z * z;
  const std::int64_t cxy = n * (below.xy + level.xy + above.xy) - x * y;
  const std::int64_t cxz = n * (above.x - below.x) - x * z;
  const std::int64_t cyz = n * (above.y - below.y) - y * z;
  const std::int64_t axx = cyy * czz - cyz * cyz, ayy = cxx * czz - cxz * cxz;
  const std::int64_t azz = cxx * cyy - cxy * cxy, axy = cxz * cyz - cxy * czz;
  const std::int64_t axz = cxy * cyz - cxz * cyy, ayz = cxy * cxz - cyz * cxx;
  std::array<std::int64_t, 3> v = axx >= ayy && axx >= azz ? std::array{axx, axy, axz}
                                  : ayy >= azz             ? std::array{axy, ayy, ayz}
                                                           : std::array{axz, ayz, azz};
  const auto shorten = [&] {
    const std::uint64_t most =
        static_cast<std::uint64_t>(std::max({std::abs(v[0]), std::abs(v[1]), std::abs(v[2])}));
    const int extra = static_cast<int>(std::bit_width(most)) - 12;
    if (extra <= 0) return;
    const std::int64_t less = (std::int64_t{1} << extra) - 1;
    for (std::int64_t& c : v) c = (c + (c < 0 ? less : 0)) >> extra;  // towards zero
  };
  shorten();
  for (int round = 0; round < 2; ++round) {
    v = {axx * v[0] + axy * v[1] + axz * v[2], axy * v[0] + ayy * v[1] + ayz * v[2],
         axz * v[0] + ayz * v[1] + azz * v[2]};
    shorten();
  }
  const std::int64_t l1 = std::abs(v[0]) + std::abs(v[1]) + std::abs(v[2]);
  NodePlane plane;
  const std::uint32_t crowd = n < 5 ? 0 : (n < 9 ? 1 : 2);
  plane.kind = static_cast<std::uint8_t>(crowd * 5 + 4);
  if (l1 == 0) return plane;
  const std::int64_t thick = v[0] * (v[0] * cxx + 2 * (v[1] * cxy + v[2] * cxz)) +
                             v[1] * (v[1] * cyy + 2 * v[2] * cyz) + v[2] * v[2] * czz;
  const std::int64_t unit = l1 * l1 * n * n;
  const unsigned flat = 1000 * thick < 29 * unit    ? 0
                        : 1000 * thick < 58 * unit  ? 1
                        : 1000 * thick < 109 * unit ? 2
                                                    : 3;
  plane.kind = static_cast<std::uint8_t>(crowd * 5 + flat);
  // floor(5 |sum| / scale), at most 15: by the reciprocal, exact since 15 scale^2 < 2^45.
  const auto scale = static_cast<std::uint64_t>(n * l1);
  const std::uint64_t reciprocal = (std::uint64_t{1} << 45U) / scale + 1;
  for (unsigned octant = 0; octant < 8; ++octant) {
    std::int64_t sum = -4 * (v[0] * x + v[1] * y + v[2] * z);
    for (std::size_t axis = 0; axis < 3; ++axis)
      sum += (octant >> axis & 1U) != 0 ? n * v[axis] : -n * v[axis];
    const auto far = static_cast<std::uint64_t>(5 * std::abs(sum));
    const std::uint64_t steps = far >= 15 * scale ? 15 : (far * reciprocal) >> 45U;
    plane.distance[octant] = static_cast<std::uint8_t>(steps);
  }
  return plane;
}

/// Planes of the patterns met last; the same ones as node_plane, sooner.
class PlaneCache {
 public:
  const NodePlane& plane(std::uint32_t pattern) noexcept {
    Entry& entry = entries_[(pattern * 0x9e3779b1U) >> 22U];
    if (entry.pattern != pattern) entry = {pattern, node_plane(pattern)};
    return entry.plane;
  }

 private:
  struct Entry {
    std::uint32_t pattern = 0;  ///< 0: none, since a node's own bit is set
    NodePlane plane;
  };
  std::array<Entry, 1024> entries_{};
};

}  // namespace planecast
