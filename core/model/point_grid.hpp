// What an integer point of a stream stands for in metres, in the decoder's own arithmetic, so that
// the encoder can hold its bound by it (docs/wire-format.md, "Points to metres").
#pragma once

#include <bit>
#include <cstdint>

#include "core/cloud/sensor_frame.hpp"
#include "core/model/grid_point.hpp"
#include "core/model/stream_config.hpp"

namespace planecast {

/// Most of a coordinate on a grid, either way [steps].
inline constexpr std::int32_t kMaxGridCoordinate = 1 << 30;

/// Metres of a step; 0: coordinates are float bits.
inline double grid_step_m(const PointStream& stream) noexcept {
  return static_cast<double>(stream.step_pm) / 1e12;
}

/// Integers in the order of the floats they stand for; every pattern of bits has one of its own.
inline std::int32_t rank_of_float(float value) noexcept {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  return std::bit_cast<std::int32_t>(bits ^ ((bits >> 31U) * 0x7fffffffU));
}

inline float float_of_rank(std::int32_t ordered) noexcept {
  const auto bits = std::bit_cast<std::uint32_t>(ordered);
  return std::bit_cast<float>(bits ^ ((bits >> 31U) * 0x7fffffffU));
}

/// A coordinate in metres: the product in double, cut to float once.
inline float grid_metres(std::int32_t steps, double step_m) noexcept {
  return step_m == 0 ? float_of_rank(steps)
                     : static_cast<float>(static_cast<double>(steps) * step_m);
}

inline Point3f grid_metres(const GridPoint& p, double step_m) noexcept {
  return {grid_metres(p.x, step_m), grid_metres(p.y, step_m), grid_metres(p.z, step_m)};
}

/// What both halves of the point coder take from the key packet.
inline PointCoding point_coding(const StreamConfig& config) noexcept {
  return {config.points.tolerance_steps, config.points.max_points};
}

}  // namespace planecast
