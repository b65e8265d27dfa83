#include "apps/common/picture.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <vector>

#include "core/io/depth_png.hpp"

namespace planecast {
namespace {

constexpr Rgb kBlack{};

int difference(Rgb a, Rgb b) {
  return std::abs(a.r - b.r) + std::abs(a.g - b.g) + std::abs(a.b - b.b);
}

TEST(Turbo, GoesFromBlueOverGreenToRed) {
  const Rgb low = turbo(0.1);
  const Rgb middle = turbo(0.5);
  const Rgb high = turbo(0.9);
  EXPECT_GT(low.b, low.r);
  EXPECT_GT(middle.g, middle.r);
  EXPECT_GT(middle.g, middle.b);
  EXPECT_GT(high.r, high.b);
  EXPECT_EQ(turbo(-5), turbo(0));
  EXPECT_EQ(turbo(7), turbo(1));
  EXPECT_EQ(turbo(std::nan("")), turbo(0));
}

TEST(DepthPicture, HolesAreBlackAndReadingsAreNot) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<float> z = {0.0F, 1.0F, nan, 2.0F, -1.0F, 100.0F};
  const Picture picture = depth_picture(z, 3, 2, {1.0, 2.0});
  EXPECT_EQ(picture.at(0, 0), kBlack);
  EXPECT_EQ(picture.at(2, 0), kBlack);
  EXPECT_EQ(picture.at(1, 1), kBlack);
  EXPECT_NE(picture.at(1, 0), kBlack);
  EXPECT_GT(picture.at(1, 0).r, picture.at(1, 0).b) << "near is red";
  EXPECT_GT(picture.at(0, 1).b, picture.at(0, 1).r) << "far is blue";
  EXPECT_EQ(picture.at(2, 1), picture.at(0, 1)) << "beyond the scale is its end";
}

TEST(DepthPicture, AFlatOrEmptyScaleIsDrawnAllTheSame) {
  const std::vector<float> flat(4, 1.5F);
  const Picture picture = depth_picture(flat, 2, 2, scale_of(flat));
  EXPECT_NE(picture.at(0, 0), kBlack);
  const std::vector<float> none(4, 0.0F);
  EXPECT_EQ(depth_picture(none, 2, 2, scale_of(none)).at(1, 1), kBlack);
}

TEST(ScaleOf, IsNotMovedByAFewWildReadings) {
  std::vector<float> z(1000);
  for (std::size_t i = 0; i < z.size(); ++i) z[i] = 1.0F + static_cast<float>(i) * 0.001F;
  z[3] = 60.0F;
  z[4] = 0.01F;
  z[5] = 0.0F;
  const ColourScale scale = scale_of(z);
  EXPECT_NEAR(scale.near_m, 1.02, 0.01);
  EXPECT_NEAR(scale.far_m, 1.98, 0.01);
}

TEST(Metres, ScalesAndKeepsHoles) {
  const std::vector<std::uint16_t> depth = {0, 1000, 65535};
  const std::vector<float> z = metres(depth, 0.001);
  EXPECT_EQ(z, (std::vector<float>{0.0F, 1.0F, 65.535F}));
}

TEST(LabelPicture, TellsNeighbouringLabelsApartAndDrawsNoneGrey) {
  for (std::uint32_t label = 0; label < 200; ++label) {
    for (std::uint32_t other = label + 1; other < label + 5; ++other)
      EXPECT_GT(difference(label_colour(label), label_colour(other)), 60) << label << " " << other;
    EXPECT_GT(difference(label_colour(label), {40, 40, 40}), 60) << label;
  }
  const std::vector<std::uint16_t> labels = {0, 0xffff, 1};
  const Picture picture = label_picture<std::uint16_t>(labels, 3, 1, 0xffff);
  EXPECT_EQ(picture.at(0, 0), label_colour(0));
  EXPECT_EQ(picture.at(1, 0), (Rgb{40, 40, 40}));
  EXPECT_EQ(picture.at(2, 0), label_colour(1));
}

TEST(SideBySide, KeepsEveryPixelAndPutsALineBetween) {
  const Rgb red{255, 0, 0};
  const Rgb blue{0, 0, 255};
  const std::vector<Picture> pictures = {Picture(3, 2, red), Picture(2, 4, blue)};
  const Picture out = side_by_side(pictures);
  ASSERT_EQ(out.width, 3U + 2U + 2U);
  ASSERT_EQ(out.height, 4U);
  EXPECT_EQ(out.at(2, 1), red);
  EXPECT_EQ(out.at(2, 2), kBlack) << "the shorter picture ends";
  EXPECT_EQ(out.at(3, 0), (Rgb{255, 255, 255}));
  EXPECT_EQ(out.at(4, 3), (Rgb{255, 255, 255}));
  EXPECT_EQ(out.at(5, 0), blue);
  EXPECT_EQ(out.at(6, 3), blue);
  EXPECT_EQ(side_by_side({}).rgb.size(), 0U);
}

TEST(SideBySide, IsWrittenAsPng) {
  const std::vector<Picture> pictures = {Picture(3, 2), Picture(3, 2)};
  const Picture out = side_by_side(pictures);
  const std::filesystem::path path =
      std::filesystem::path(testing::TempDir()) / "planecast_side_by_side.png";
  ASSERT_TRUE(write_rgb_png(path, out.width, out.height, out.rgb).ok());
  EXPECT_GT(std::filesystem::file_size(path), 50U);
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace planecast
