// The prediction of one pixel: what it falls back on, when it takes the surface, and that whatever
// the neighbourhood, levels and contexts stay in range.
#include "core/predict/pixel_predictor.hpp"

#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "core/base/random.hpp"

namespace planecast {
namespace {

PixelState level(std::uint16_t value) {
  PixelState s;
  s.level = value;
  return s;
}

std::vector<std::uint8_t> half_widths(std::uint8_t value) {
  return std::vector<std::uint8_t>(65536, value);
}

PixelPrediction predict(const Neighbourhood& n, std::uint8_t half = 0) {
  return predict_pixel(n, false, 0, 0, 0, half_widths(half).data(), 65535, 77);
}

TEST(PixelPredictor, NeighboursPredictByTheirMedian) {
  Neighbourhood n;
  n.l = level(100);
  n.u = level(110);
  n.ul = level(105);
  EXPECT_EQ(predict(n).level, 105);
  n.ul = level(90);
  EXPECT_EQ(predict(n).level, 110);
  n.ul = level(150);
  EXPECT_EQ(predict(n).level, 100);
}

TEST(PixelPredictor, MissingNeighboursAreReplacedInAFixedOrder) {
  Neighbourhood n;
  EXPECT_EQ(predict(n).level, 77) << "the pixel coded last";
  n.uu = 11;
  EXPECT_EQ(predict(n).level, 11);
  n.ll = 12;
  EXPECT_EQ(predict(n).level, 12);
  n.ul = level(13);
  EXPECT_EQ(predict(n).level, 13);
  n.ur = level(14);
  EXPECT_EQ(predict(n).level, 14);
  n.u = level(15);
  EXPECT_EQ(predict(n).level, 15);
  n.l = level(16);
  n.ul = level(0);
  EXPECT_EQ(predict(n).level, 16);
}

TEST(PixelPredictor, TheSurfacePredictsWhereThereIsNoNeighbour) {
  const auto half = half_widths(2);
  const PixelPrediction p = predict_pixel({}, true, 1000 * 256 + 128, 0, 0, half.data(), 65535, 77);
  EXPECT_EQ(p.level, 1001);
  EXPECT_EQ(p.surface, 1001);
  EXPECT_EQ(p.neighbour, 77);
  EXPECT_EQ(p.half_width, 2);
}

TEST(PixelPredictor, TheSideThatMissedLessIsTaken) {
  const auto half = half_widths(0);
  Neighbourhood n;
  n.l = n.u = n.ul = n.ur = level(1000);
  n.l.surface_miss = n.u.surface_miss = 3;
  EXPECT_EQ(predict_pixel(n, true, 1002 * 256, 0, 0, half.data(), 65535, 1).level, 1000)
      << "the surface missed by more than its advance";
  n.l.neighbour_miss = n.u.neighbour_miss = 2;
  const PixelPrediction p = predict_pixel(n, true, 1002 * 256, 0, 0, half.data(), 65535, 1);
  EXPECT_EQ(p.level, p.surface);
}

TEST(PixelPredictor, DecodedNeighboursDrawTheSurfaceTowardsThem) {
  const auto half = half_widths(0);
  Neighbourhood n;
  n.l = n.u = n.ul = n.ur = level(1010);
  const PixelPrediction p = predict_pixel(n, true, 1000 * 256, 0, 0, half.data(), 65535, 1);
  EXPECT_EQ(p.surface, 1009) << "nine tenths of the way";
  n.l = n.u = n.ul = n.ur = level(1100);
  EXPECT_EQ(predict_pixel(n, true, 1000 * 256, 0, 0, half.data(), 65535, 1).surface, 1000)
      << "too far off to be on the surface";
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
    const auto some_state = [&] {
      PixelState s;
      s.level = some_level();
      s.correction = static_cast<std::int8_t>(static_cast<int>(random.below(5)) - 2);
      s.surface_miss = static_cast<std::uint8_t>(random.below(kMissCap + 1));
      s.neighbour_miss = static_cast<std::uint8_t>(random.below(kMissCap + 1));
      return s;
    };
    const Neighbourhood n{some_state(), some_state(), some_state(),
                          some_state(), some_level(), some_level()};
    const auto signed_q8 = [&](int bits) {
      return static_cast<std::int32_t>(random.next() >> (32 - bits)) - (1 << (bits - 1));
    };
    const PixelPrediction p =
        predict_pixel(n, random.below(2) != 0, signed_q8(29), signed_q8(25), signed_q8(25),
                      half.data(), last, 1 + static_cast<std::int32_t>(random.below(last)));
    for (const std::int32_t l : {p.level, p.surface, p.neighbour}) {
      ASSERT_GE(l, 1);
      ASSERT_LE(l, last);
    }
    ASSERT_EQ(p.half_width, half[p.level]);
    ASSERT_LT(p.correction_context, kCorrectionContexts);
    ASSERT_LT(p.sign_context, kSignContexts);
    ASSERT_LT(p.magnitude_context, kMagnitudeContexts);
    const std::int32_t became = 1 + static_cast<std::int32_t>(random.below(last));
    const PixelState state =
        pixel_state(p, became, static_cast<std::int32_t>(random.below(27)) - 13);
    ASSERT_EQ(state.level, became);
    ASSERT_LE(std::abs(state.correction), 2);
    ASSERT_LE(state.surface_miss, kMissCap);
    ASSERT_LE(state.neighbour_miss, kMissCap);
  }
}

}  // namespace
}  // namespace planecast
