// How small: the paper's ratio and bits per point. Integers in, plain figures out.
#pragma once

#include <cstdint>

namespace planecast {

/// A raw point of the paper's ratio: x, y and z as 32-bit floats.
inline constexpr std::uint64_t kRawBytesPerPoint = 12;

/// Bytes saved in percent, Eq. 10 of the paper: (1 - bytes / (12 points)) * 100. Negative when the
/// packed frame is larger than the raw one; 0 when there are no points.
double ratio_percent(std::uint64_t bytes, std::uint64_t points) noexcept;

/// Bits of `bytes` for each of `points`; 0 when there are no points.
double bits_per_point(std::uint64_t bytes, std::uint64_t points) noexcept;

}  // namespace planecast
