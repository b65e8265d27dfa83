// Segmentation finds the planes of the simulator's room, the same ones every time, and survives
// frames that hold nothing to find.
#include "core/segment/region_growing.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "core/sim/sim_room.hpp"

namespace planecast {
namespace {

struct Bench {
  StreamConfig config;
  std::vector<std::int32_t> storage;
  RayTable rays;
  Arena arena;
  Segmenter segmenter;

  explicit Bench(const CameraModel& camera, NoiseModel noise = {}) {
    config.camera = camera;
    config.noise = noise;
    storage.resize(ray_table_entries(camera));
    EXPECT_EQ(build_ray_table(camera, storage, rays), Status::kOk);
    arena = std::move(*Arena::map(8U << 20U));
    segmenter.layout(arena, 640, 480);
    EXPECT_FALSE(arena.failed());
  }
};

CameraModel camera_of(std::uint32_t width, std::uint32_t height) {
  Intrinsics in;
  in.fx = in.fy = 400;
  in.cx = width / 2.0;
  in.cy = height / 2.0;
  return *quantise(in, width, height);
}

TEST(RegionGrowing, RegionsOfTheRoomAreNineTenthsOneTrueSurface) {
  Result<RoomSimulator> simulator = RoomSimulator::create(default_sim_config());
  ASSERT_TRUE(simulator.ok());
  DepthImage depth;
  std::vector<std::uint16_t> truth;
  Pose pose;
  simulator->render(0, depth, truth, pose);
  Bench bench(simulator->camera(), simulator->config().noise);
  RegionMap map;
  ASSERT_EQ(bench.segmenter.process(bench.config, bench.rays, depth.depth, map), Status::kOk);
  ASSERT_GE(map.regions, 3);
  std::map<int, std::map<int, int>> votes;
  std::size_t inside = 0, readings = 0, right = 0;
  for (std::uint32_t v = 0; v < depth.height; ++v) {
    for (std::uint32_t u = 0; u < depth.width; ++u) {
      const std::size_t i = std::size_t{v} * depth.width + u;
      if (depth.depth[i] == 0) continue;
      ++readings;
      const int label = map.labels[(v / 8) * map.cells_wide + u / 8];
      if (label == 0) continue;
      ++inside;
      ++votes[label][truth[i]];
    }
  }
  for (const auto& [label, ids] : votes) {
    int most = 0;
    for (const auto& [id, n] : ids) most = std::max(most, n);
    right += static_cast<std::size_t>(most);
  }
  EXPECT_GT(inside, readings / 2);
  EXPECT_GT(right, inside * 9 / 10);
}

TEST(RegionGrowing, GivesTheSameLabelsEveryTime) {
  Result<RoomSimulator> simulator = RoomSimulator::create(default_sim_config());
  ASSERT_TRUE(simulator.ok());
  DepthImage depth;
  std::vector<std::uint16_t> truth;
  Pose pose;
  simulator->render(3, depth, truth, pose);
  Bench a(simulator->camera()), b(simulator->camera());
  RegionMap first, second;
  ASSERT_EQ(a.segmenter.process(a.config, a.rays, depth.depth, first), Status::kOk);
  ASSERT_EQ(b.segmenter.process(b.config, b.rays, depth.depth, second), Status::kOk);
  ASSERT_EQ(b.segmenter.process(b.config, b.rays, depth.depth, second), Status::kOk);
  EXPECT_TRUE(std::equal(first.labels.begin(), first.labels.end(), second.labels.begin(),
                         second.labels.end()));
}

TEST(RegionGrowing, TakesFramesWithNothingToFind) {
  for (const auto& [w, h] : {std::pair{1U, 1U}, {640U, 1U}, {7U, 5U}, {64U, 48U}}) {
    for (const int value : {0, 1000, 65535}) {
      Bench bench(camera_of(w, h));
      RegionMap map;
      const std::vector<std::uint16_t> depth(w * h, static_cast<std::uint16_t>(value));
      ASSERT_EQ(bench.segmenter.process(bench.config, bench.rays, depth, map), Status::kOk);
      EXPECT_EQ(map.labels.size(), std::size_t{(w + 7) / 8} * ((h + 7) / 8));
      if (value == 0) EXPECT_EQ(map.regions, 0);
    }
  }
  Bench bench(camera_of(64, 48));
  RegionMap map;
  EXPECT_EQ(bench.segmenter.process(bench.config, bench.rays, std::vector<std::uint16_t>(5), map),
            Status::kWrongSize);
}

TEST(RegionGrowing, JoinsAPlaneThatAGapOfHolesParts) {
  std::vector<std::uint16_t> depth(320 * 240, 2000);
  for (std::uint32_t v = 0; v < 240; ++v) {
    for (std::uint32_t u = 160; u < 168; ++u) depth[v * 320 + u] = 0;
  }
  Bench bench(camera_of(320, 240));
  RegionMap map;
  ASSERT_EQ(bench.segmenter.process(bench.config, bench.rays, depth, map), Status::kOk);
  EXPECT_EQ(map.regions, 1);
}

}  // namespace
}  // namespace planecast
