#include "apps/common/suggestion.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace planecast {
namespace {

const std::vector<std::string> kNames = {"tolerance", "off-surface", "outliers",   "range",
                                         "rate",      "regenerate",  "slice-bytes"};

TEST(Suggestion, FindsTheNameMeant) {
  EXPECT_EQ(suggestion("tolerence", kNames), "tolerance");
  EXPECT_EQ(suggestion("off_surface", kNames), "off-surface");
  EXPECT_EQ(suggestion("OffSurface", kNames), "off-surface");
  EXPECT_EQ(suggestion("outlier", kNames), "outliers");
  EXPECT_EQ(suggestion("rangge", kNames), "range");
}

TEST(Suggestion, TakesABeginningThatOnlyOneNameHas) {
  EXPECT_EQ(suggestion("tol", kNames), "tolerance");
  EXPECT_EQ(suggestion("sl", kNames), "slice-bytes");
  EXPECT_EQ(suggestion("ra", kNames), "") << "two names begin so";
}

TEST(Suggestion, StaysSilentWhenNothingIsNear) {
  EXPECT_EQ(suggestion("quality", kNames), "");
  EXPECT_EQ(suggestion("", kNames), "");
  EXPECT_EQ(suggestion("x", {}), "");
  EXPECT_EQ(did_you_mean("quality", kNames), "");
}

TEST(Suggestion, AsksInAFullSentence) {
  EXPECT_EQ(did_you_mean("rnge", kNames), "; did you mean 'range'?");
}

}  // namespace
}  // namespace planecast
