// Rays, levels and bounds of one configuration, built as both halves build them.
#pragma once

#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "core/predict/bound_table.hpp"
#include "core/predict/level_table.hpp"

namespace planecast::test {

struct PredictBench {
  StreamConfig config;
  std::vector<std::int32_t> storage;
  RayTable rays;
  Arena arena = std::move(*Arena::map(std::size_t{8} << 20U));
  LevelTable levels;
  BoundTable bounds;

  explicit PredictBench(StreamConfig stream) : config(std::move(stream)) {
    storage.resize(ray_table_entries(config.camera));
    EXPECT_EQ(build_ray_table(config.camera, storage, rays), Status::kOk);
    levels.layout(arena);
    bounds.layout(arena, config.camera.pixels());
    EXPECT_FALSE(arena.failed());
    EXPECT_EQ(levels.build(config.lattice), Status::kOk);
    EXPECT_EQ(bounds.build(config, rays, levels), Status::kOk);
  }
};

}  // namespace planecast::test
