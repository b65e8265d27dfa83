// What fitting reads of a stream: the tables that the coder will predict with.
#pragma once

#include "core/model/stream_config.hpp"
#include "core/predict/bound_table.hpp"
#include "core/predict/level_table.hpp"
#include "core/sensor/ray_table.hpp"

namespace planecast {

/// Tables of one stream, all built for `config`. Not owned; all four must be set.
struct FitTables {
  const StreamConfig* config = nullptr;
  const RayTable* rays = nullptr;
  const LevelTable* levels = nullptr;
  const BoundTable* bounds = nullptr;
};

/// Blocks of 8 x 8 pixels along each side of the tables' image.
inline std::uint32_t blocks_wide(const FitTables& tables) noexcept {
  return (tables.rays->width + 7U) / 8U;
}
inline std::uint32_t blocks_high(const FitTables& tables) noexcept {
  return (tables.rays->height + 7U) / 8U;
}

}  // namespace planecast
