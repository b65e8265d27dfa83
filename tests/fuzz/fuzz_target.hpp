// What every fuzz target shares. A target is one function from bytes; it is linked with libFuzzer
// by clang, or with replay.cpp by any compiler.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include "core/cloud/sensor_frame.hpp"

/// libFuzzer's entry point: any bytes. Returns 0; a fault ends the process.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace planecast::test {

/// Ends the process, as a memory error would, when what must hold for any input does not.
inline void claim(bool holds, const char* what) noexcept {
  if (holds) return;
  std::fprintf(stderr, "claim does not hold: %s\n", what);
  std::abort();
}

/// What every reader promises of a cloud it returns: as many points as its shape says, each either
/// finite or with a NaN.
inline void claim_sound(const PointCloud& cloud) noexcept {
  claim(cloud.points.size() == std::size_t{cloud.width} * cloud.height, "points fill the shape");
  for (const Point3f& p : cloud.points) {
    for (const float v : {p.x, p.y, p.z})
      claim(v - v == 0 || v != v, "a coordinate is finite or NaN");
  }
}

}  // namespace planecast::test
