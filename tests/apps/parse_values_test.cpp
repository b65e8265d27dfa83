#include "apps/common/parse_values.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "apps/common/options.hpp"

namespace planecast {
namespace {

/// A refusal must be a usage error that repeats what was read and shows an example.
template <class T>
void expect_refused(const Result<T>& result, const std::string& text) {
  ASSERT_FALSE(result.ok()) << "'" << text << "' was taken";
  EXPECT_EQ(result.error().status, Status::kUsage);
  EXPECT_NE(result.error().message.find(text), std::string::npos);
  const bool mend = result.error().message.find("for example") != std::string::npos;
  EXPECT_TRUE(mend) << result.error().message;
}

struct ToleranceCase {
  const char* text;
  ToleranceKind kind;
  double value;
};

TEST(ParseTolerance, ReadsEveryKind) {
  const std::vector<ToleranceCase> cases = {
      {"0", ToleranceKind::kLossless, 0},
      {"lossless", ToleranceKind::kLossless, 0},
      {"10mm", ToleranceKind::kMetres, 0.01},
      {"0.01m", ToleranceKind::kMetres, 0.01},
      {"5cm", ToleranceKind::kMetres, 0.05},
      {"500um", ToleranceKind::kMetres, 0.0005},
      {"2.5 mm", ToleranceKind::kMetres, 0.0025},
      {"1e-2m", ToleranceKind::kMetres, 0.01},
      {"2sigma", ToleranceKind::kSigma, 2},
      {"0.5sigma", ToleranceKind::kSigma, 0.5},
      {"surfaces", ToleranceKind::kSurfaces, 3},
      {"surfaces:3", ToleranceKind::kSurfaces, 3},
      {"surfaces:2.5", ToleranceKind::kSurfaces, 2.5},
  };
  for (const ToleranceCase& c : cases) {
    const Result<Tolerance> tolerance = parse_tolerance(c.text);
    ASSERT_TRUE(tolerance.ok()) << c.text << ": " << tolerance.error().message;
    EXPECT_EQ(tolerance->kind, c.kind) << c.text;
    EXPECT_DOUBLE_EQ(tolerance->value, c.value) << c.text;
  }
}

TEST(ParseTolerance, RefusesWhatIsNone) {
  for (const char* text :
       {"",        "x",       "10",       "0.01",      "-1mm",       "0mm",
        "10km",    "10 m m",  "nan",      "nanm",      "infm",       "sigma",
        "0sigma",  "-2sigma", "2sigmas3", "surfaces:", "surfaces:0", "surfaces:x",
        "surface", "1e400mm", "0.1um",    "2000m",     "10mm,5mm"}) {
    expect_refused(parse_tolerance(text), text);
  }
}

TEST(ParseTolerance, SaysThatAUnitIsMissing) {
  EXPECT_NE(parse_tolerance("0.01").error().message.find("has no unit"), std::string::npos);
}

TEST(ParseTolerance, IsReadBackFromItsOwnText) {
  for (const char* text : {"0", "10mm", "2.5mm", "2sigma", "0.5sigma", "surfaces:3"}) {
    const Tolerance tolerance = *parse_tolerance(text);
    EXPECT_EQ(to_string(tolerance), text);
    EXPECT_EQ(*parse_tolerance(to_string(tolerance)), tolerance);
  }
}

TEST(ParseCamera, ReadsFigures) {
  const Result<CameraChoice> camera = parse_camera("383.8,384,321.7, 236.8");
  ASSERT_TRUE(camera.ok());
  EXPECT_DOUBLE_EQ(camera->intrinsics.fx, 383.8);
  EXPECT_DOUBLE_EQ(camera->intrinsics.fy, 384.0);
  EXPECT_DOUBLE_EQ(camera->intrinsics.cx, 321.7);
  EXPECT_DOUBLE_EQ(camera->intrinsics.cy, 236.8);
  EXPECT_DOUBLE_EQ(camera->intrinsics.metres_per_unit, 0.001);
  EXPECT_FALSE(camera->unit_given);
  EXPECT_FALSE(camera->noise.has_value());
}

TEST(ParseCamera, ReadsTheUnit) {
  const Result<CameraChoice> camera = parse_camera("383.8,383.8,321.7,236.8,0.00025");
  ASSERT_TRUE(camera.ok());
  EXPECT_DOUBLE_EQ(camera->intrinsics.metres_per_unit, 0.00025);
  EXPECT_TRUE(camera->unit_given);
}

TEST(ParseCamera, KnowsPresets) {
  const Result<CameraChoice> camera = parse_camera("kinect1");
  ASSERT_TRUE(camera.ok());
  EXPECT_EQ(camera->preset, "kinect1");
  EXPECT_EQ(camera->width, 640U);
  EXPECT_GT(camera->intrinsics.fx, 100.0);
  ASSERT_TRUE(camera->noise.has_value());
  EXPECT_GT(camera->noise->s(), 0.0);
}

TEST(ParseCamera, RefusesFiguresThatAreNoCamera) {
  for (const char* text :
       {"", "525", "525,525", "525,525,320", "0,525,320,240", "525,-1,320,240", "525,525,x,240",
        "525,525,320,240,0", "525,525,320,240,2", "525,525,320,240,0.001,1", "525,525,,240",
        "525,525,1e9,240", "nan,525,320,240"}) {
    expect_refused(parse_camera(text), text);
  }
}

TEST(ParseCamera, NamesTheNearestPreset) {
  const Result<CameraChoice> camera = parse_camera("kinnect1");
  expect_refused(camera, "kinnect1");
  EXPECT_NE(camera.error().message.find("did you mean 'kinect1'?"), std::string::npos);
}

TEST(ParseDistortion, ReadsFourOrFiveCoefficients) {
  const Result<Distortion> four = parse_distortion("-0.05,0.06,0.0002,-0.0001");
  ASSERT_TRUE(four.ok());
  EXPECT_DOUBLE_EQ(four->k1, -0.05);
  EXPECT_DOUBLE_EQ(four->p2, -0.0001);
  EXPECT_DOUBLE_EQ(four->k3, 0.0);
  EXPECT_DOUBLE_EQ(parse_distortion("0,0,0,0,0.5")->k3, 0.5);
  for (const char* text : {"", "1,2,3", "1,2,3,4,5,6", "1,2,3,a", "1000,0,0,0"})
    expect_refused(parse_distortion(text), text);
}

TEST(ParseRange, ReadsMetresAndUnits) {
  EXPECT_DOUBLE_EQ(parse_range("0.2,10")->min_m, 0.2);
  EXPECT_DOUBLE_EQ(parse_range("0.2,10")->max_m, 10.0);
  EXPECT_DOUBLE_EQ(parse_range("20cm,10m")->min_m, 0.2);
  EXPECT_DOUBLE_EQ(parse_range("0,8")->min_m, 0.0);
  for (const char* text : {"", "10", "10,0.2", "1,1", "-1,5", "a,b", "0,5,9", "0,5kg", "0,"})
    expect_refused(parse_range(text), text);
}

TEST(ParseSize, ReadsWidthAndHeight) {
  EXPECT_EQ(parse_size("640x480")->width, 640U);
  EXPECT_EQ(parse_size("640x480")->height, 480U);
  for (const char* text : {"", "640", "640x", "x480", "640x480x2", "0x480", "640x-1", "640*480",
                           "99999x1", "640.5x480", "99999999999999999999x1"}) {
    expect_refused(parse_size(text), text);
  }
}

TEST(ParseWhole, RefusesWhatIsOutsideOrNotWhole) {
  EXPECT_EQ(*parse_whole("30", 3, 200, "30"), 30U);
  EXPECT_EQ(*parse_whole("18446744073709551615", 0, ~std::uint64_t{0}, "1"), ~std::uint64_t{0});
  for (const char* text : {"", "2", "201", "3.5", "-3", "30x", "99999999999999999999"})
    expect_refused(parse_whole(text, 3, 200, "30"), text);
}

TEST(ParseNumber, NamesTheLimits) {
  EXPECT_DOUBLE_EQ(*parse_number("2.5", 0, 90, "3"), 2.5);
  const Result<double> result = parse_number("91", 0, 90, "3");
  expect_refused(result, "91");
  EXPECT_NE(result.error().message.find("between 0 and 90"), std::string::npos);
  for (const char* text : {"", "inf", "nan", "1e999", "3deg"})
    expect_refused(parse_number(text, 0, 90, "3"), text);
}

}  // namespace
}  // namespace planecast
