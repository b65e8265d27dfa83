#include "tests/golden/integer_scene.hpp"

#include <algorithm>

#include "core/base/random.hpp"
#include "core/predict/level_table.hpp"

namespace planecast::test {

namespace {

// A scene says k = C / z, the lattice's index, of a pixel; 0 = a hole.
template <class Scene>
std::vector<std::uint16_t> draw(std::uint32_t width, std::uint32_t height, const Lattice& lattice,
                                std::uint64_t seed, const Scene& scene) {
  Pcg32 random(seed);
  std::vector<std::uint16_t> out;
  out.reserve(std::size_t{width} * height);
  for (std::uint32_t v = 0; v < height; ++v) {
    for (std::uint32_t u = 0; u < width; ++u) {
      std::uint32_t k = scene(u, v);
      const std::uint32_t noise = random.below(16);  // one in eight is a level off
      if (k != 0) k = noise == 0 ? k + 1 : noise == 1 ? k - 1 : k;
      out.push_back(k == 0 ? std::uint16_t{0}
                           : static_cast<std::uint16_t>(lattice_depth(lattice, k)));
    }
  }
  return out;
}

}  // namespace

// k is linear over the image of a plane; the largest is what a ray meets first.
std::vector<std::uint16_t> integer_room(std::uint32_t width, std::uint32_t height,
                                        const Lattice& lattice, std::uint64_t seed) {
  return draw(width, height, lattice, seed, [&](std::uint32_t u, std::uint32_t v) {
    const bool beside = 8 * v > 4 * height && 8 * v < 7 * height;
    if (beside && 8 * u > 3 * width && 8 * u < 5 * width) return 240U;
    if (beside && 8 * u >= 5 * width && 16 * u < 11 * width) return 0U;
    return std::max({190 - 120 * u / width, 60 + 90 * u / width, 20 + 160 * v / height});
  });
}

std::vector<std::uint16_t> integer_wall(std::uint32_t width, std::uint32_t height,
                                        const Lattice& lattice, std::uint64_t seed) {
  return draw(width, height, lattice, seed, [&](std::uint32_t u, std::uint32_t v) {
    if (4 * u > 3 * width && 4 * v > 3 * height) return 8 * u > 7 * width ? 0U : 240U;
    return 100 + 40 * u / width + 30 * v / height;
  });
}

std::vector<std::uint16_t> integer_dome(std::uint32_t width, std::uint32_t height,
                                        const Lattice& lattice, std::uint64_t seed) {
  return draw(width, height, lattice, seed, [&](std::uint32_t u, std::uint32_t v) {
    const std::uint32_t x = 2 * u > width ? 2 * u - width : width - 2 * u;
    const std::uint32_t y = 2 * v > height ? 2 * v - height : height - 2 * v;
    return 200 - 60 * (x * x + y * y) / (width * width);
  });
}

}  // namespace planecast::test
