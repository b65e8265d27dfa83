// The starts of models that the library unpacks are the tables of core/wire/*_trained.inc, value by
// value: what docs/wire-format.md gives, what training wrote.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "core/wire/start_code.hpp"
#include "core/wire/start_writer.hpp"
#include "core/wire/trained_tables.hpp"

namespace planecast {
namespace {

using namespace trained;

// Decisions seen by class (docs/wire-format.md, 5, 5.1 and 16).
constexpr std::uint8_t kAges[16] = {0, 1, 2, 3, 4, 5, 6, 9, 12, 16, 22, 30, 40, 60, 80, 100};
constexpr std::uint8_t kMixedSeen[16] = {0, 1, 2, 3, 4, 6, 8, 10, 14, 18, 24, 32, 44, 60, 80, 110};
constexpr std::uint8_t kPointSeen[16] = {0, 1, 1, 1, 2, 2, 3, 4, 5, 6, 8, 10, 13, 17, 23, 30};

// Whether a model starts as the word says.
::testing::AssertionResult starts_as(std::uint16_t start, const std::uint8_t (&seen)[16],
                                     std::uint32_t fast, std::uint32_t slow, unsigned age) {
  const std::uint32_t p = (start >> 4U) * 16U + 8U;
  if (fast == p && slow == p && age == seen[start & 15U]) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure()
         << start << " unpacked as " << fast << " " << slow << " " << age;
}

TEST(PackedStarts, OfResidualsAreTheTable) {
  const auto models = std::make_unique<ResidualModels>();
  for (const bool every_count : {false, true}) {
    unpack_residuals(every_count, *models);
    const ResidualModels& table = kResiduals[every_count ? 1 : 0];
    for (int i = 0; i < kShapeContexts; ++i) {
      ASSERT_TRUE(std::ranges::equal(models->shape[i].bounds, table.shape[i].bounds))
          << every_count << " shape " << i;
    }
    for (int i = 0; i < kErrorContexts; ++i) {
      ASSERT_TRUE(std::ranges::equal(models->errors[i].bounds, table.errors[i].bounds))
          << every_count << " errors " << i;
    }
  }
}

TEST(PackedStarts, OfTilesAreTheTable) {
  for (const bool lossless : {true, false}) {
    const auto* models = reinterpret_cast<const BitModel*>(&trained_models(lossless));
    for (std::size_t i = 0; i < kTileModelCount; ++i) {
      ASSERT_TRUE(starts_as(kTile[lossless ? 0 : 1][i], kAges, models[i].fast(), models[i].slow(),
                            models[i].age()))
          << lossless << " " << i;
    }
  }
}

TEST(PackedStarts, OfMixedTilesAreTheTables) {
  constexpr int kNearest = kMaskInputContexts[0], kWide = kMaskInputContexts[kWideMask];
  for (const bool lossless : {true, false}) {
    const MixModels& models = trained_mix_models(lossless);
    const std::uint16_t* start = kMixed[lossless ? 0 : 1];
    const auto check = [&](const MixedModel& m) {
      return starts_as(*start++, kMixedSeen, m.fast, m.slow, m.seen);
    };
    for (const auto& context : models.pixel) {
      for (const MixedModel& model : context) ASSERT_TRUE(check(model));
    }
    for (int i = 0; i < kAllMaskContexts; ++i) {
      if (i < kNearest || i >= kNearest + kWide) {
        ASSERT_TRUE(check(models.mask[i])) << i;
        continue;
      }
      const MixedModel &wide = models.mask[i], &nearest = models.mask[i % kNearest];
      ASSERT_EQ(wide.fast, nearest.fast);
      ASSERT_EQ(wide.slow, nearest.slow);
      ASSERT_EQ(wide.seen, std::min<std::uint8_t>(nearest.seen, 2));
    }
    EXPECT_EQ(start, kMixed[lossless ? 0 : 1] + kMixStarts);
    const std::int16_t* weight = kMixedWeights[lossless ? 0 : 1];
    for (const auto& set : models.pixel_mixers) {
      for (const auto& mixer : set) {
        for (const std::int32_t w : mixer.weight) ASSERT_EQ(w, *weight++ * 256);
      }
    }
    for (const auto& mixer : models.mask_mixers) {
      for (const std::int32_t w : mixer.weight) ASSERT_EQ(w, *weight++ * 256);
    }
  }
}

TEST(PackedStarts, OfPointsAreTheTables) {
  const PointModels& models = trained_point_models();
  const auto* occupancy = reinterpret_cast<const MixedModel*>(&models.occupancy);
  for (std::size_t i = 0; i < kOccupancyModelCount; ++i) {
    ASSERT_TRUE(starts_as(kOccupancy[i], kPointSeen, occupancy[i].fast, occupancy[i].slow,
                          occupancy[i].seen))
        << i;
  }
  const auto* counts = reinterpret_cast<const BitModel*>(&models.single);
  for (std::size_t i = 0; i < kCountModelCount; ++i) {
    ASSERT_TRUE(starts_as(kCounts[i], kAges, counts[i].fast(), counts[i].slow(), counts[i].age()))
        << i;
  }
}

TEST(PackedStarts, NumbersOfAnyWidthComeBack) {
  constexpr std::uint32_t kNumbers[] = {0, 1, 2, 3, 4, 5, 127, 128, 255, 4095, 32767, 32768, 65535};
  StartModels<1, kNumberDecisions> models;
  StartWriter writer;
  for (const std::uint32_t n : kNumbers) code_number(writer, StartView(models, 0, 0, 0), n);
  const std::vector<std::uint8_t> bytes = writer.finish();
  models = {};
  StartReader reader(bytes);
  for (const std::uint32_t n : kNumbers)
    EXPECT_EQ(code_number(reader, StartView(models, 0, 0, 0), 0), n);
}

}  // namespace
}  // namespace planecast
