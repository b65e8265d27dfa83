// What a point-file writer did with the points: written, or left out because they hold no reading.
#pragma once

#include <cstddef>

namespace planecast {

struct WriteReport {
  std::size_t points_written = 0;
  std::size_t points_left_out = 0;  ///< not finite, in a format without a sign for them
};

}  // namespace planecast
