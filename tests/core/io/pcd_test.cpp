#include "core/io/pcd.hpp"

#include <gtest/gtest.h>

#include "tests/core/io/io_test_support.hpp"

namespace planecast {
namespace {

using test::file_content;
using test::random_cloud;
using test::same_points;
using test::TempFolder;

const std::string kHeader =
    "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 2\nHEIGHT 1\n"
    "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2\n";

TEST(Pcd, RoundTripsEveryShapeWithHolesBitForBit) {
  const TempFolder folder;
  for (const auto& [width, height] :
       {std::pair{0U, 1U}, {1U, 1U}, {500U, 1U}, {32U, 24U}, {7U, 2U}}) {
    PointCloud cloud = random_cloud(width, height, width * 31U + height, 0.2);
    cloud.viewpoint = {0.5, 0.5, -0.5, 0.5, 1.25, -2.5, 1e-3};
    const auto written = write_pcd(folder / "a.pcd", cloud);
    ASSERT_TRUE(written.ok()) << written.error().message;
    EXPECT_EQ(written->points_written, cloud.points.size());
    EXPECT_EQ(written->points_left_out, 0U);
    const auto read = read_pcd(folder / "a.pcd");
    ASSERT_TRUE(read.ok()) << read.error().message;
    EXPECT_EQ(read->width, width);
    EXPECT_EQ(read->height, height);
    EXPECT_TRUE(same_points(read->points, cloud.points));
    EXPECT_EQ(read->viewpoint.qy, -0.5);
    EXPECT_EQ(read->viewpoint.tz, 1e-3);
    EXPECT_EQ(read->origin_x, 0);
    EXPECT_TRUE(read->dropped_fields.empty());
  }
}

TEST(Pcd, RefusesToWriteAShapeThatIsNotThePoints) {
  const TempFolder folder;
  PointCloud cloud = random_cloud(4, 4, 1);
  cloud.width = 5;
  const auto written = write_pcd(folder / "a.pcd", cloud);
  ASSERT_FALSE(written.ok());
  EXPECT_EQ(written.error().status, Status::kUsage);
  EXPECT_FALSE(std::filesystem::exists(folder / "a.pcd"));
}

TEST(Pcd, WriteSaysWhyItFailed) {
  const TempFolder folder;
  const auto written = write_pcd(folder / "no_such_folder/a.pcd", random_cloud(2, 2, 1));
  ASSERT_FALSE(written.ok());
  EXPECT_EQ(written.error().status, Status::kWriteFailed);
  EXPECT_NE(written.error().message.find("No such file"), std::string::npos);
}

TEST(Pcd, ReadsAsciiWithNanOfEverySpelling) {
  const TempFolder folder;
  const auto path =
      folder.file("a.pcd", kHeader + "DATA ascii\n1.5 +2 -3e-1\r\n\nnan -nan 1.#QNAN");
  const auto cloud = read_pcd(path);
  ASSERT_TRUE(cloud.ok()) << cloud.error().message;
  ASSERT_EQ(cloud->points.size(), 2U);
  EXPECT_EQ(cloud->points[0].x, 1.5F);
  EXPECT_EQ(cloud->points[0].y, 2.0F);
  EXPECT_EQ(cloud->points[0].z, -0.3F);
  EXPECT_TRUE(std::isnan(cloud->points[1].x));
  EXPECT_TRUE(std::isnan(cloud->points[1].z));
}

TEST(Pcd, TakesXyzInAnyOrderAndNamesWhatItDrops) {
  const TempFolder folder;
  std::string content =
      "# .PCD v.7\nVERSION .7\nFIELDS ring z _ hist x y\nSIZE 2 4 1 4 8 4\nTYPE U F U F F F\n"
      "COUNT 1 1 3 2 1 1\nWIDTH 2\nHEIGHT 1\nPOINTS 2\nDATA binary\n";
  for (int i = 0; i < 2; ++i) {
    test::append_raw(content, static_cast<std::uint16_t>(7));
    test::append_raw(content, 3.0F + static_cast<float>(i));
    content.append(3, '\x55');
    test::append_raw(content, 0.25F);
    test::append_raw(content, 0.75F);
    test::append_raw(content, 1.0 + i);
    test::append_raw(content, 2.0F + static_cast<float>(i));
  }
  const auto cloud = read_pcd(folder.file("a.pcd", content));
  ASSERT_TRUE(cloud.ok()) << cloud.error().message;
  EXPECT_TRUE(same_points(cloud->points, {{1, 2, 3}, {2, 3, 4}}));
  EXPECT_EQ(cloud->dropped_fields, (std::vector<std::string>{"ring", "hist"}));
}

TEST(Pcd, ReadsOldHeadersWithoutTypeCountWidth) {
  const TempFolder folder;
  const auto path =
      folder.file("a.pcd", "VERSION .5\nCOLUMNS x y z\nPOINTS 1\nDATA ascii\n1 2 3\n");
  const auto cloud = read_pcd(path);
  ASSERT_TRUE(cloud.ok()) << cloud.error().message;
  EXPECT_TRUE(same_points(cloud->points, {{1, 2, 3}}));
  EXPECT_EQ(cloud->width, 1U);
  EXPECT_EQ(cloud->viewpoint.qw, 1);
}

TEST(Pcd, KeepsMillimetresOfMapCoordinates) {
  const TempFolder folder;
  const auto path = folder.file(
      "a.pcd", kHeader + "DATA ascii\n512345.125 5412345.25 99.5\n512346.375 5412340.75 98.5\n");
  const auto cloud = read_pcd(path);
  ASSERT_TRUE(cloud.ok()) << cloud.error().message;
  EXPECT_EQ(cloud->origin_z, 0);  // only the axes that need it
  const auto absolute_x = [](const PointCloud& c, std::size_t i) {
    return c.points[i].x + c.origin_x;
  };
  EXPECT_EQ(absolute_x(*cloud, 0), 512345.125);
  EXPECT_EQ(absolute_x(*cloud, 1), 512346.375);
  EXPECT_EQ(cloud->points[1].y + cloud->origin_y, 5412340.75);
  EXPECT_EQ(cloud->origin_x, std::floor(cloud->origin_x));

  ASSERT_TRUE(write_pcd(folder / "b.pcd", *cloud).ok());
  const auto again = read_pcd(folder / "b.pcd");
  ASSERT_TRUE(again.ok()) << again.error().message;
  EXPECT_EQ(absolute_x(*again, 0), 512345.125);
  EXPECT_EQ(absolute_x(*again, 1), 512346.375);
}

TEST(Pcd, OneWildPointDoesNotMoveTheOrigin) {
  const TempFolder folder;
  const auto cloud = read_pcd(folder.file(
      "a.pcd", test::patched(test::patched(kHeader, "WIDTH 2", "WIDTH 3"), "POINTS 2", "POINTS 3") +
                   "DATA ascii\n500000.125 0 0\n500001.25 0 0\n1e20 0 0\n"));
  ASSERT_TRUE(cloud.ok()) << cloud.error().message;
  EXPECT_EQ(cloud->points[0].x + cloud->origin_x, 500000.125);
}

TEST(Pcd, Float32CoordinatesAreTakenBitForBitHoweverLarge) {
  const TempFolder folder;
  PointCloud cloud = random_cloud(3, 1, 5);
  cloud.points[1].x = 5412345.5F;
  ASSERT_TRUE(write_pcd(folder / "a.pcd", cloud).ok());
  const auto read = read_pcd(folder / "a.pcd");
  ASSERT_TRUE(read.ok());
  EXPECT_EQ(read->origin_x, 0);
  EXPECT_TRUE(same_points(read->points, cloud.points));
}

TEST(Pcd, InfinityBecomesNoReading) {
  const TempFolder folder;
  const auto cloud = read_pcd(folder.file("a.pcd", kHeader + "DATA ascii\ninf 0 0\n0 -inf 0\n"));
  ASSERT_TRUE(cloud.ok());
  EXPECT_TRUE(std::isnan(cloud->points[0].x));
  EXPECT_TRUE(std::isnan(cloud->points[1].y));
}

TEST(Pcd, OneColumnIsAList) {
  const TempFolder folder;
  const std::string header =
      test::patched(test::patched(kHeader, "WIDTH 2", "WIDTH 1"), "HEIGHT 1", "HEIGHT 2");
  const auto cloud = read_pcd(folder.file("a.pcd", header + "DATA ascii\n0 0 1\n0 0 2\n"));
  ASSERT_TRUE(cloud.ok());
  EXPECT_FALSE(cloud->organised());
  EXPECT_EQ(cloud->width, 2U);
}

}  // namespace
}  // namespace planecast
