// What the contexts of the point tree say, against the sentences of docs/wire-format.md, section
// 16, evaluated plainly.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/wire/bit_mixer.hpp"
#include "core/wire/point_levels.hpp"

namespace planecast {
namespace {

TEST(PointContexts, SquashIsTheLogisticFunctionAndStretchItsInverse) {
  for (std::int32_t x = -2047; x <= 2047; ++x) {
    EXPECT_NEAR(squash(x), 65536 / (1 + std::exp(-x / 256.0)), 520) << x;
    if (x > -2047) EXPECT_GE(squash(x), squash(x - 1));
  }
  for (std::uint32_t p = 64; p < 4032; ++p)
    EXPECT_NEAR(squash(detail::kStretch[p]) / 16.0, p, 6) << p;
}

TEST(PointContexts, MixingLearnsWhichModelToTrust) {
  std::mt19937 random(3);
  BitMixer<2> mixer;
  MixedModel good, bad;
  double bits = 0;
  for (int i = 0; i < 4000; ++i) {
    const bool bit = random() % 16 == 0;
    bad.fast = bad.slow = static_cast<std::uint16_t>(random());
    MixedModel* const models[2] = {&good, &bad};
    const MixedBit<2> mixed(mixer, models);
    const double p = mixed.probability / 65536.0;
    if (i >= 2000) bits -= std::log2(bit ? p : 1 - p);
    mixed.learn(mixer, models, bit);
  }
  EXPECT_LT(bits / 2000, 0.38);  // the entropy of 1/16 is 0.337
  EXPECT_GT(mixer.weight[0], 3 * std::abs(mixer.weight[1]));
}

// Neighbours at random, children at random: the sums by table against sums over positions.
TEST(PointContexts, SurroundingsAreSumsOverTheChildrenAround) {
  std::mt19937 random(4);
  for (int round = 0; round < 300; ++round) {
    Surroundings around;
    int state[6][6][6] = {};  // children of 3 x 3 x 3 nodes: 0 empty, 1 unknown, 2 occupied
    for (unsigned d = 0; d < 27; ++d) {
      const auto kind = static_cast<unsigned>(random() % 3);
      const auto mask = static_cast<std::uint32_t>(random() % 256);
      if (d != kCentreBit && kind == 0) continue;
      if (d != kCentreBit) around.add(d, kind == 2, mask);
      for (unsigned octant = 0; octant < 8; ++octant) {
        const bool set = (mask >> octant & 1U) != 0;
        if (d == kCentreBit && set) around.add_sibling(octant);
        state[2 * (d % 3) + (octant & 1U)][2 * (d / 3 % 3) + (octant >> 1U & 1U)]
             [2 * (d / 9) + (octant >> 2U)] = d != kCentreBit && kind == 1 ? 1 : (set ? 2 : 0);
      }
    }
    for (unsigned octant = 0; octant < 8; ++octant) {
      const int at[3] = {2 + static_cast<int>(octant & 1U), 2 + static_cast<int>(octant >> 1U & 1U),
                         2 + static_cast<int>(octant >> 2U)};
      unsigned weight = 0, unknown = 0, faces = 0;
      for (int i = 0; i < 27; ++i) {
        const int step[3] = {i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1};
        const int far = std::abs(step[0]) + std::abs(step[1]) + std::abs(step[2]);
        const int s = state[at[0] + step[0]][at[1] + step[1]][at[2] + step[2]];
        if (far == 0) continue;
        weight += s == 2 ? static_cast<unsigned>(4 - far) : 0;
        unknown += s == 1 ? 1 : 0;
        for (int axis = 0, place = 1; axis < 3; ++axis, place *= 3) {
          const int beyond = at[axis] + step[axis];
          if (far == 1 && step[axis] != 0 && (beyond < 2 || beyond > 3))
            faces += static_cast<unsigned>(s * place);
        }
      }
      EXPECT_EQ(around.weight(octant), weight);
      EXPECT_EQ(around.unknown(octant), unknown);
      EXPECT_EQ(around.faces(octant), faces);
    }
  }
}

TEST(PointContexts, ThePlaneIsThatOfTheOccupiedNeighbours) {
  std::uint32_t flat = 0, slope = 0;
  for (int a = -1; a <= 1; ++a)
    for (int b = -1; b <= 1; ++b) {
      flat |= 1U << pattern_bit(a, b, 0);
      slope |= 1U << pattern_bit(a, b, a);
    }
  const NodePlane level = node_plane(flat);
  EXPECT_EQ(level.kind, 10);                                               // nine neighbours, flat
  for (const unsigned distance : level.distance) EXPECT_EQ(distance, 5U);  // half a child
  const NodePlane tilted = node_plane(slope);
  EXPECT_EQ(tilted.kind, 10);
  for (unsigned octant = 0; octant < 8; ++octant) {
    const bool on = (octant & 1U) == octant >> 2U;  // x and z alike: on z = x
    EXPECT_EQ(tilted.distance[octant], on ? 0U : 5U) << octant;
  }
  EXPECT_EQ(node_plane(1U << kCentreBit).kind, 4);
  EXPECT_EQ(node_plane(1U << kCentreBit | 1U).kind, 4);  // two points span no plane
}

TEST(PointContexts, TheCacheGivesWhatThePlaneIs) {
  std::mt19937 random(5);
  PlaneCache cache;
  for (int i = 0; i < 20000; ++i) {
    const auto pattern =
        static_cast<std::uint32_t>((random() & random() & 0x7ffffffU) | 1U << kCentreBit);
    const NodePlane plane = node_plane(pattern);
    const NodePlane& cached = cache.plane(i % 3 == 0 ? pattern & ~0x1ffU : pattern);
    if (i % 3 == 0) continue;
    EXPECT_EQ(cached.kind, plane.kind);
    EXPECT_EQ(cached.distance, plane.distance);
  }
}

}  // namespace
}  // namespace planecast
