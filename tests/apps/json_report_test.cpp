#include "apps/common/json_report.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace planecast {
namespace {

using Json = nlohmann::ordered_json;

TEST(JsonReport, AddsTheMeanOfEveryNumber) {
  const Json frames = {{{"bytes", 100}, {"d1_mm", 1.0}, {"name", "a"}},
                       {{"bytes", 201}, {"d1_mm", 2.0}, {"name", "b"}}};
  const Json report = report_of(frames);
  EXPECT_EQ(report["frames"].size(), 2U);
  EXPECT_EQ(report["frames"][1]["bytes"], 201);
  EXPECT_DOUBLE_EQ(report["mean"]["bytes"].get<double>(), 150.5);
  EXPECT_DOUBLE_EQ(report["mean"]["d1_mm"].get<double>(), 1.5);
  EXPECT_FALSE(report["mean"].contains("name"));
}

TEST(JsonReport, WhatIsNotFiniteIsNullAndSoIsItsMean) {
  const Json frames = {{{"d1_mm", std::numeric_limits<double>::infinity()}}, {{"d1_mm", 2.0}}};
  const Json report = report_of(frames);
  EXPECT_TRUE(report["frames"][0]["d1_mm"].is_null());
  EXPECT_TRUE(report["mean"]["d1_mm"].is_null());
  EXPECT_EQ(Json::parse(report.dump()), report);
}

TEST(JsonReport, LeavesOutWhatSomeFrameDoesNotHave) {
  const Json report = report_of({{{"a", 1}, {"b", 2}}, {{"a", 3}}});
  EXPECT_EQ(report["mean"], (Json{{"a", 2.0}}));
}

TEST(JsonReport, KeepsTheOrderOfKeys) {
  const Json report = report_of(Json::array({{{"z", 1}, {"a", 2}}}));
  EXPECT_EQ(report["frames"][0].dump(), R"({"z":1,"a":2})");
  EXPECT_EQ(report["mean"].dump(), R"({"z":1.0,"a":2.0})");
}

TEST(JsonReport, NoFramesGiveAnEmptyMean) {
  EXPECT_EQ(report_of(Json::array()).dump(), R"({"frames":[],"mean":{}})");
}

}  // namespace
}  // namespace planecast
