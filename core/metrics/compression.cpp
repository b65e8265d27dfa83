#include "core/metrics/compression.hpp"

namespace planecast {

double ratio_percent(std::uint64_t bytes, std::uint64_t points) noexcept {
  if (points == 0) return 0.0;
  const double raw = static_cast<double>(points) * static_cast<double>(kRawBytesPerPoint);
  return (1.0 - static_cast<double>(bytes) / raw) * 100.0;
}

double bits_per_point(std::uint64_t bytes, std::uint64_t points) noexcept {
  if (points == 0) return 0.0;
  return 8.0 * static_cast<double>(bytes) / static_cast<double>(points);
}

}  // namespace planecast
