// The seed of one simulated frame.
#pragma once

#include <cstdint>

namespace planecast {

/// Every frame has its own numbers, so that frames may be rendered in any order. SplitMix64's
/// mixing (Steele, Lea, Flood 2014): neighbouring frames must not draw alike.
inline std::uint64_t frame_seed(std::uint64_t seed, std::uint64_t frame) noexcept {
  std::uint64_t z = seed * 0x9E3779B97F4A7C15ULL + frame;
  z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9ULL;
  z = (z ^ (z >> 27U)) * 0x94D049BB133111EBULL;
  return z ^ (z >> 31U);
}

}  // namespace planecast
