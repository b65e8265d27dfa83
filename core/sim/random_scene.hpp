// Random sensors in random rooms, for property tests: whatever comes out must survive the codec.
#pragma once

#include <cstdint>

#include "core/sim/sim_room.hpp"
#include "core/sim/sim_scene.hpp"

namespace planecast {

/// A sensor and a scene that RoomSimulator::create accepts.
struct RandomScene {
  SimConfig config;
  SimScene scene;
};

/// The scene of a seed, always the same: 1 x 1 to 640 x 480 pixels (single rows and columns
/// included), stereo, time of flight or no noise, with and without lattice, distortion, room walls,
/// drop-outs and motion; boxes, spheres and cylinders anywhere, also around the camera.
RandomScene random_scene(std::uint64_t seed);

}  // namespace planecast
