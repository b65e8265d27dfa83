// Tables of the tree of points that are computed when the program starts.
#include "core/wire/point_levels.hpp"
#include "core/wire/point_neighbours.hpp"

namespace planecast::detail {
namespace {

std::array<NeighbourSums, 27> make_neighbour_sums() noexcept {
  std::array<NeighbourSums, 27> table{};
  for (unsigned d = 0; d < 27; ++d) {
    const int x = static_cast<int>(d % 3) - 1, y = static_cast<int>(d / 3 % 3) - 1,
              z = static_cast<int>(d / 9) - 1;
    for (unsigned octant = 0; octant < 8; ++octant) {
      const std::uint64_t weight = weights_of(x, y, z, octant, false);
      table[d].unknown += weights_of(x, y, z, octant, true);
      table[d].unknown_faces += face_of(d, octant, 1);
      for (unsigned half = 0; half < 16; ++half) {
        if ((half >> (octant & 3U) & 1U) == 0) continue;
        table[d].weights[octant >> 2U][half] += weight;
        table[d].faces[octant >> 2U][half] += face_of(d, octant, 2);
      }
    }
  }
  return table;
}

std::array<LayerSums, 512> make_layer_sums() noexcept {
  std::array<LayerSums, 512> table{};
  for (unsigned pattern = 0; pattern < 512; ++pattern) {
    LayerSums& sums = table[pattern];
    for (int y = -1; y <= 1; ++y) {
      for (int x = -1; x <= 1; ++x) {
        if ((pattern >> static_cast<unsigned>((x + 1) + 3 * (y + 1)) & 1U) == 0) continue;
        sums.n = static_cast<std::int8_t>(sums.n + 1);
        sums.x = static_cast<std::int8_t>(sums.x + x);
        sums.y = static_cast<std::int8_t>(sums.y + y);
        sums.xx = static_cast<std::int8_t>(sums.xx + x * x);
        sums.yy = static_cast<std::int8_t>(sums.yy + y * y);
        sums.xy = static_cast<std::int8_t>(sums.xy + x * y);
      }
    }
  }
  return table;
}

}  // namespace

const std::array<NeighbourSums, 27> kNeighbourSums = make_neighbour_sums();
const std::array<LayerSums, 512> kLayerSums = make_layer_sums();

}  // namespace planecast::detail
