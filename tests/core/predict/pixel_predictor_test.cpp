// The prediction of one pixel: what it falls back on, when it takes the surface, and that whatever
// the neighbourhood, levels and contexts stay in range.
#include "core/predict/pixel_predictor.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>
#include <vector>

#include "core/base/random.hpp"

namespace planecast {
namespace {

// A neighbourhood whose rows the test fills in.
struct Around {
  PixelRow rows[3];
  static constexpr std::size_t kAt = 10;

  void set_l(std::uint16_t level) { rows[0].level[kAt - 1] = level; }
  void set_u(std::uint16_t level) { rows[1].level[kAt] = level; }
  void set_ul(std::uint16_t level) { rows[1].level[kAt - 1] = level; }
  void set_ur(std::uint16_t level) { rows[1].level[kAt + 1] = level; }
  void set_ll(std::uint16_t level) { rows[0].level[kAt - 2] = level; }
  void set_uu(std::uint16_t level) { rows[2].level[kAt] = level; }
  void set_near(std::uint16_t level) {
    set_l(level);
    set_u(level);
    set_ul(level);
    set_ur(level);
  }
  void set_misses(std::uint32_t surface, std::uint32_t neighbour) {
    rows[0].past[kAt - 1].misses = rows[1].past[kAt].misses = surface << 16U | neighbour;
  }
  Neighbourhood view() const { return {rows[0], rows[1], rows[2], kAt}; }
};

std::vector<std::uint8_t> half_widths(std::uint8_t value) {
  return std::vector<std::uint8_t>(65536, value);
}

PixelPrediction predict(const Around& n) {
  static const auto halves = half_widths(0);
  return predict_pixel(n.view(), PixelPlace(halves.data(), 65535), 77);
}

PixelPrediction predict_on(const Around& n, std::int32_t surface_q8, std::uint8_t half = 0) {
  const auto halves = half_widths(half);
  PixelPlace place(halves.data(), 65535);
  place.lie_on({surface_q8, 0, 0}, 0);
  return predict_pixel(n.view(), place, 77);
}

TEST(PixelPredictor, NeighboursPredictByTheirMedian) {
  Around n;
  n.set_l(100);
  n.set_u(110);
  n.set_ul(105);
  EXPECT_EQ(predict(n).level, 105);
  n.set_ul(90);
  EXPECT_EQ(predict(n).level, 110);
  n.set_ul(150);
  EXPECT_EQ(predict(n).level, 100);
}

TEST(PixelPredictor, MissingNeighboursAreReplacedInAFixedOrder) {
  Around n;
  EXPECT_EQ(predict(n).level, 77) << "the pixel coded last";
  n.set_uu(11);
  EXPECT_EQ(predict(n).level, 11);
  n.set_ll(12);
  EXPECT_EQ(predict(n).level, 12);
  n.set_ul(13);
  EXPECT_EQ(predict(n).level, 13);
  n.set_ur(14);
  EXPECT_EQ(predict(n).level, 14);
  n.set_u(15);
  EXPECT_EQ(predict(n).level, 15);
  n.set_l(16);
  n.set_ul(0);
  EXPECT_EQ(predict(n).level, 16);
}

TEST(PixelPredictor, TheSurfacePredictsWhereThereIsNoNeighbour) {
  const PixelPrediction p = predict_on(Around(), 1000 * 256 + 128, 2);
  EXPECT_EQ(p.level, 1001);
  EXPECT_EQ(p.surface, 1001);
  EXPECT_EQ(p.neighbour, 77);
  EXPECT_EQ(p.half_width, 2);
}

TEST(PixelPredictor, TheSideThatMissedLessIsTaken) {
  Around n;
  n.set_near(1000);
  n.set_misses(3, 0);
  EXPECT_EQ(predict_on(n, 1002 * 256).level, 1000) << "the surface missed by more than its advance";
  n.set_misses(3, 2);
  const PixelPrediction p = predict_on(n, 1002 * 256);
  EXPECT_EQ(p.level, p.surface);
}

TEST(PixelPredictor, DecodedNeighboursDrawTheSurfaceTowardsThem) {
  Around n;
  n.set_near(1010);
  EXPECT_EQ(predict_on(n, 1000 * 256).surface, 1009) << "nine tenths of the way";
  n.set_near(1100);
  EXPECT_EQ(predict_on(n, 1000 * 256).surface, 1000) << "too far off to be on the surface";
}

TEST(PixelPredictor, DriftFollowsTheSlopesAndTheWeightsOfThoseThatCount) {
  Pcg32 random(5);
  const auto halves = half_widths(1);
  for (int i = 0; i < 20'000; ++i) {
    Around n;
    const std::int32_t at = 1000 * 256 + static_cast<std::int32_t>(random.below(512));
    const std::int32_t dx = static_cast<std::int32_t>(random.below(2000)) - 1000;
    const std::int32_t dy = static_cast<std::int32_t>(random.below(2000)) - 1000;
    struct Side {
      std::int32_t expected_q8, weight;
      void (Around::*set)(std::uint16_t);
    };
    const Side sides[4] = {{at - dx, 4, &Around::set_l},
                           {at - dy, 4, &Around::set_u},
                           {at - dx - dy, 1, &Around::set_ul},
                           {at + dx - dy, 2, &Around::set_ur}};
    std::int64_t sum = 0;
    std::size_t weight = 0;
    for (const Side& side : sides) {
      const auto level =
          static_cast<std::int32_t>(random.below(3) == 0 ? 0 : 980 + random.below(40));
      (n.*side.set)(static_cast<std::uint16_t>(level));
      const std::int32_t off = level * 256 - side.expected_q8;
      if (level == 0 || std::abs(off) > 15 * 256) continue;
      sum += std::int64_t{off} * side.weight;
      weight += static_cast<std::size_t>(side.weight);
    }
    PixelPlace place(halves.data(), 65535);
    place.lie_on({at - dx, dx, dy}, 0);
    place.step_right();
    ASSERT_EQ(detail::surface_drift_q8(n.view(), place), (sum * detail::kDriftScale[weight]) >> 16);
  }
}

TEST(PixelPredictor, StepsLeaveNoLevelUncovered) {
  for (int half = 0; half <= 255; ++half) {
    PixelPrediction p;
    p.half_width = half;
    EXPECT_GE(p.step(), 1);
    EXPECT_LE(p.step(), 2 * half + 1);
  }
}

TEST(PixelPredictor, ActivityGrowsWithTheDifferencesAndShrinksWithTheHalfWidth) {
  for (int half = 0; half <= 255; ++half) {
    int last = 0;
    for (int sum = 0; sum < 200'000; sum += 1 + sum / 64) {
      const int activity = detail::activity_class(sum, half);
      ASSERT_GE(activity, last);
      ASSERT_LT(activity, kActivityClasses);
      last = activity;
    }
  }
  EXPECT_EQ(detail::activity_class(0, 0), 0);
  EXPECT_GT(detail::activity_class(30, 1), detail::activity_class(30, 12));
}

TEST(PixelPredictor, LevelsAndContextsStayInRangeWhateverTheNeighbourhood) {
  Pcg32 random(17);
  std::vector<std::uint8_t> half(65536);
  for (auto& h : half)
    h = static_cast<std::uint8_t>(random.below(4) == 0 ? random.next() : random.below(4));
  for (int i = 0; i < 300'000; ++i) {
    const std::int32_t last = 1 + static_cast<std::int32_t>(random.below(65535));
    const auto some_level = [&] {
      return static_cast<std::uint16_t>(random.below(3) == 0 ? 0 : 1 + random.below(last));
    };
    Around n;
    for (PixelRow& row : n.rows) {
      for (std::size_t x = Around::kAt - 2; x <= Around::kAt + 2; ++x) {
        row.level[x] = some_level();
        row.past[x] = {random.below(kMissCap + 1) << 16U | random.below(kMissCap + 1),
                       static_cast<std::uint8_t>(random.below(3)),
                       static_cast<std::int8_t>(static_cast<int>(random.below(3)) - 1), 0};
      }
    }
    const auto signed_q8 = [&](int bits) {
      return static_cast<std::int32_t>(random.next() >> (32 - bits)) - (1 << (bits - 1));
    };
    PixelPlace place(half.data(), last);
    if (random.below(2) != 0) place.lie_on({signed_q8(29), signed_q8(25), signed_q8(25)}, 0);
    const PixelPrediction p =
        predict_pixel(n.view(), place, 1 + static_cast<std::int32_t>(random.below(last)));
    for (const std::int32_t l : {p.level, p.surface, p.neighbour}) {
      ASSERT_GE(l, 1);
      ASSERT_LE(l, last);
    }
    ASSERT_EQ(p.half_width, half[p.level]);
    const int activity = pixel_activity(n.view(), p);
    ASSERT_LT(correction_context(n.view(), activity), kCorrectionContexts);
    ASSERT_LT(sign_context(n.view(), p), kSignContexts);
    ASSERT_LT(magnitude_context(n.view(), activity), kMagnitudeContexts);
    PixelRow& row = n.rows[0];
    const PixelPast& past = row.past[Around::kAt];
    keep_predicted(row, Around::kAt, p);
    ASSERT_EQ(row.level[Around::kAt], p.level);
    ASSERT_EQ(p.by_surface ? past.misses >> 16U : past.misses & 0xffffU, 0U);
    const PixelPast predicted = past;
    keep_corrected(row, Around::kAt, p, p.level, 1);
    ASSERT_EQ(past.misses, predicted.misses) << "both ways agree on what was missed";
    const std::int32_t became = 1 + static_cast<std::int32_t>(random.below(last));
    const std::int32_t size = 1 + static_cast<std::int32_t>(random.below(13));
    keep_corrected(row, Around::kAt, p, became, random.below(2) != 0 ? size : -size);
    ASSERT_EQ(row.level[Around::kAt], became);
    ASSERT_EQ(past.size, std::min(size, 2));
    ASSERT_EQ(std::abs(past.lean), 1);
    ASSERT_LE(past.misses >> 16U, kMissCap);
    ASSERT_LE(past.misses & 0xffffU, kMissCap);
  }
}

TEST(PixelPredictor, TheMedianIsThatOfSorting) {
  Pcg32 random(23);
  for (int i = 0; i < 100'000; ++i) {
    Around n;
    const std::uint32_t most = random.below(2) != 0 ? 65535 : 8;
    std::int32_t levels[3];
    for (std::int32_t& level : levels) level = 1 + static_cast<std::int32_t>(random.below(most));
    n.set_l(static_cast<std::uint16_t>(levels[0]));
    n.set_u(static_cast<std::uint16_t>(levels[1]));
    n.set_ul(static_cast<std::uint16_t>(levels[2]));
    std::int32_t sorted[3] = {levels[0], levels[1], levels[0] + levels[1] - levels[2]};
    std::sort(std::begin(sorted), std::end(sorted));
    ASSERT_EQ(predict(n).level, sorted[1]);
  }
}

}  // namespace
}  // namespace planecast
