#include "core/io/xyz_text.hpp"

#include <gtest/gtest.h>

#include "tests/core/io/io_test_support.hpp"

namespace planecast {
namespace {

using test::same_points;
using test::TempFolder;

TEST(XyzText, RoundTripsValidPointsBitForBitAndCountsTheOthers) {
  const TempFolder folder;
  for (const std::uint32_t width : {0U, 1U, 777U}) {
    const PointCloud cloud = test::random_cloud(width, 1, width, width > 1 ? 0.1 : 0.0);
    const auto written = write_xyz_text(folder / "a.xyz", cloud);
    ASSERT_TRUE(written.ok()) << written.error().message;
    const auto valid = test::valid_points(cloud);
    EXPECT_EQ(written->points_written, valid.size());
    EXPECT_EQ(written->points_left_out, cloud.points.size() - valid.size());
    const auto read = read_xyz_text(folder / "a.xyz");
    ASSERT_TRUE(read.ok()) << read.error().message;
    EXPECT_TRUE(same_points(read->points, valid));
  }
}

struct Accepted {
  std::string content;
  std::vector<std::string> dropped;
};

class XyzDialects : public testing::TestWithParam<Accepted> {};

TEST_P(XyzDialects, GiveTheSameTwoPoints) {
  const TempFolder folder;
  const auto cloud = read_xyz_text(folder.file("a.txt", GetParam().content));
  ASSERT_TRUE(cloud.ok()) << cloud.error().message;
  EXPECT_TRUE(same_points(cloud->points, {{1, 2, 3}, {4, 5, 6.5}}));
  EXPECT_EQ(cloud->dropped_fields, GetParam().dropped);
}

INSTANTIATE_TEST_SUITE_P(
    Each, XyzDialects,
    testing::Values(Accepted{"1 2 3\n4 5 6.5\n", {}}, Accepted{"1 2 3\r\n4 5 6.5", {}},
                    Accepted{"\xEF\xBB\xBF  1\t2   3  \n\n\t4 5 6.5\n", {}},
                    Accepted{"1,2,3\n4, 5 , 6.5\n", {}}, Accepted{"1;2;3\n4;5;6.5\n", {}},
                    Accepted{"# a comment, with 1 2 3\n1 2 3 # here\n// x\n4 5 6.5\n", {}},
                    Accepted{"x y z\n1 2 3\n4 5 6.5\n", {}},
                    Accepted{"some words\n1 2 3\n4 5 6.5\n", {}},
                    Accepted{"2\n1 2 3\n4 5 6.5\n", {}},
                    Accepted{"1 2 3 9 8\n4 5 6.5 a b\n", {"column 4", "column 5"}},
                    Accepted{"1,2,3,,8\n4,5,6.5,7,\n", {"column 4", "column 5"}},
                    Accepted{"//X,Y,Z,Intensity\n1,2,3,9\n4,5,6.5,9\n", {"intensity"}},
                    Accepted{"\"ID\",\"Z\",\"X\",\"Y\"\n0,3,1,2\n1,6.5,4,5\n", {"id"}},
                    Accepted{"id x y z\n2\n0 1 2 3\n1 4 5 6.5\n", {"id"}}));

struct Refused {
  std::string content;
  std::string message;
};

class XyzRefusals : public testing::TestWithParam<Refused> {};

TEST_P(XyzRefusals, NameTheLine) {
  const TempFolder folder;
  const auto path = folder.file("a.txt", GetParam().content);
  EXPECT_REFUSED(read_xyz_text(path), path, GetParam().message);
}

INSTANTIATE_TEST_SUITE_P(Each, XyzRefusals,
                         testing::Values(Refused{"1 2 3\n4 5\n", "line 2: there are 2 values"},
                                         Refused{"1 2 3\n4 5 6 7\n", "line 2: there are 4 values"},
                                         Refused{"1 2\n", "line 1: there are 2 values"},
                                         Refused{"1 two 3\n4 5 6\n", "line 1: 'two'"},
                                         Refused{"1 2 3\n4 five 6\n", "line 2: 'five'"},
                                         Refused{"1,,3\n4,,6\n", "line 1: '' is not a number"},
                                         Refused{"1,5 2,5 3,5\n", "line 1: the columns"},
                                         Refused{"x y z\n1,5;2,5;3,5\n", "line 2: the columns"},
                                         Refused{"words here\nmore words here\n", "line 2"},
                                         Refused{"words here\n", "no point"},
                                         Refused{"3\n1 2 3\n4 5 6\n", "promises 3"},
                                         Refused{"1 2 3\n1 2 3\n1 2 1e300\n", "float32"},
                                         Refused{"1 2 1e9999\n", "not a number"}));

TEST(XyzText, KeepsLargeOffsets) {
  const TempFolder folder;
  const auto cloud = read_xyz_text(
      folder.file("a.xyz", "482345.123 5412345.456 10\n482346.123 5412346.456 nan\n"));
  ASSERT_TRUE(cloud.ok()) << cloud.error().message;
  EXPECT_NEAR(cloud->points[0].x + cloud->origin_x, 482345.123, 1e-6);
  EXPECT_NEAR(cloud->points[1].y + cloud->origin_y, 5412346.456, 1e-6);
  EXPECT_TRUE(std::isnan(cloud->points[1].z));
  ASSERT_TRUE(write_xyz_text(folder / "b.xyz", *cloud).ok());
  const auto again = read_xyz_text(folder / "b.xyz");
  ASSERT_TRUE(again.ok());
  ASSERT_EQ(again->points.size(), 1U);
  EXPECT_NEAR(again->points[0].x + again->origin_x, 482345.123, 1e-6);
}

TEST(XyzText, NoTruncationCrashesOrAddsPoints) {
  const TempFolder folder;
  const std::string content = "x,y,z,i\n1.5,2.5,3.5,1\n-4.5,5.5,6.5,2\n";
  test::for_every_truncation(folder, "cut.xyz", content,
                             [](const std::filesystem::path& path, std::size_t length) {
                               SCOPED_TRACE(length);
                               const auto cloud = read_xyz_text(path);
                               if (!cloud.ok()) return;
                               EXPECT_LE(cloud->points.size(), 2U);
                             });
  const auto cut = folder.file("cut.xyz", content.substr(0, content.size() - 5));
  EXPECT_REFUSED(read_xyz_text(cut), cut, "line 3");
}

}  // namespace
}  // namespace planecast
