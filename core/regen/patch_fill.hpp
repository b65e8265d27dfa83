// Brings the points of a patch back: as many as it had, inside its cells, at the height its surface
// says (Algorithm 2 of the paper). Decoder half: integers until the last product.
#pragma once

#include <cstdint>
#include <span>

#include "core/base/arena.hpp"
#include "core/base/random.hpp"
#include "core/base/status.hpp"
#include "core/model/patch.hpp"

namespace planecast {

/// The generator of a slice's random points: every slice has its own, so that it decodes alone.
inline Pcg32 patch_generator(const PointStream& stream, std::uint32_t frame, std::uint32_t slice) {
  return Pcg32((std::uint64_t{stream.seed} << 32U) | frame, slice);
}

/// Regenerates patches. One thread; memory (4 bytes for each of kMaxPatchCells) from the arena.
class PatchFiller {
 public:
  void layout(Arena& arena) noexcept;

  /// Writes out.size() = patch.points points [m] to `out`. `cells`: wide * high, row by row, not 0
  /// inside. kRandom takes them uniformly over the area of the cells from `generator`; kLattice
  /// lays rows as far apart as points within a row, and leaves the generator alone. Every point
  /// lies in a cell that is inside. kWrongSize: sizes disagree; kFieldRange: check_patch() refuses,
  /// or no cell is inside. O(cells + points), no allocation.
  Status fill(const Patch& patch, std::span<const std::uint8_t> cells, const PointStream& stream,
              Pcg32& generator, std::span<Point3f> out) noexcept;

 private:
  void fill_random(const Patch& patch, std::uint32_t inside, double unit_m, Pcg32& generator,
                   std::span<Point3f> out) noexcept;
  void fill_lattice(const Patch& patch, std::span<const std::uint8_t> cells, std::uint32_t inside,
                    double unit_m, std::span<Point3f> out) noexcept;

  std::span<std::uint32_t> inside_;  ///< numbers of the cells inside, in order
};

}  // namespace planecast
