// Scenes in integers alone: the same counts on every machine, at any size, with nothing stored.
#pragma once

#include <cstdint>
#include <vector>

#include "core/model/stream_config.hpp"

namespace planecast::test {

/// A room's corner (two walls, a floor) with a box before it, a band of holes and noise of one
/// lattice level, as counts of `lattice`. Row-major, width * height.
std::vector<std::uint16_t> integer_room(std::uint32_t width, std::uint32_t height,
                                        const Lattice& lattice, std::uint64_t seed);

/// One wall with a small box before it and some holes: a surface in an image of few pixels.
std::vector<std::uint16_t> integer_wall(std::uint32_t width, std::uint32_t height,
                                        const Lattice& lattice, std::uint64_t seed);

/// A dome: inverse depth is of degree two over the image.
std::vector<std::uint16_t> integer_dome(std::uint32_t width, std::uint32_t height,
                                        const Lattice& lattice, std::uint64_t seed);

}  // namespace planecast::test
