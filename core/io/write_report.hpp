// What a point-file writer did with the points: written, or left out because they hold no reading.
#pragma once

#include <cstdint>

namespace planecast {

struct WriteReport {
  std::uint64_t points_written = 0;
  std::uint64_t points_left_out =
      0;  ///< invalid (not finite) points in a format without a sign for them
};

}  // namespace planecast
