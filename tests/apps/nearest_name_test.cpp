#include "apps/common/nearest_name.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace planecast {
namespace {

const std::vector<std::string> kNames = {"tolerance", "off-surface", "outliers",   "range",
                                         "rate",      "regenerate",  "slice-bytes"};

TEST(EditDistance, CountsSlipsOfTheFinger) {
  EXPECT_EQ(edit_distance("", ""), 0U);
  EXPECT_EQ(edit_distance("rate", ""), 4U);
  EXPECT_EQ(edit_distance("", "rate"), 4U);
  EXPECT_EQ(edit_distance("rate", "rate"), 0U);
  EXPECT_EQ(edit_distance("rate", "rat"), 1U);
  EXPECT_EQ(edit_distance("rate", "rqte"), 1U);
  EXPECT_EQ(edit_distance("rate", "raet"), 1U);
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3U);
}

TEST(NearestName, FindsTheNameMeant) {
  EXPECT_EQ(nearest_name("tolerence", kNames), "tolerance");
  EXPECT_EQ(nearest_name("off_surface", kNames), "off-surface");
  EXPECT_EQ(nearest_name("OffSurface", kNames), "off-surface");
  EXPECT_EQ(nearest_name("outlier", kNames), "outliers");
  EXPECT_EQ(nearest_name("ragne", kNames), "range");
}

TEST(NearestName, TakesABeginningThatOnlyOneNameHas) {
  EXPECT_EQ(nearest_name("tol", kNames), "tolerance");
  EXPECT_EQ(nearest_name("sl", kNames), "slice-bytes");
}

TEST(NearestName, StaysSilentWhenNothingIsNear) {
  EXPECT_EQ(nearest_name("quality", kNames), "");
  EXPECT_EQ(nearest_name("", kNames), "");
  EXPECT_EQ(nearest_name("x", {}), "");
  EXPECT_EQ(did_you_mean("quality", kNames), "");
}

TEST(NearestName, AsksInAFullSentence) {
  EXPECT_EQ(did_you_mean("rnage", kNames), "; did you mean 'range'?");
}

}  // namespace
}  // namespace planecast
