#include "core/io/kitti_bin.hpp"

#include <gtest/gtest.h>

#include "tests/core/io/io_test_support.hpp"

namespace planecast {
namespace {

using test::TempFolder;

TEST(KittiBin, RoundTripsValidPointsAndCountsTheOthers) {
  const TempFolder folder;
  for (const std::uint32_t width : {0U, 1U, 777U}) {
    const PointCloud cloud = test::random_cloud(width, 1, width, width > 1 ? 0.1 : 0.0);
    const auto written = write_kitti_bin(folder / "a.bin", cloud);
    ASSERT_TRUE(written.ok()) << written.error().message;
    const auto valid = test::valid_points(cloud);
    EXPECT_EQ(written->points_written, valid.size());
    EXPECT_EQ(written->points_left_out, cloud.points.size() - valid.size());
    EXPECT_EQ(std::filesystem::file_size(folder / "a.bin"), 16 * valid.size());
    const auto read = read_kitti_bin(folder / "a.bin");
    ASSERT_TRUE(read.ok()) << read.error().message;
    EXPECT_TRUE(test::same_points(read->points, valid));
    EXPECT_EQ(read->dropped_fields, std::vector<std::string>{"intensity"});
  }
}

TEST(KittiBin, EverySizeThatIsNotWholeRecordsIsAnError) {
  const TempFolder folder;
  ASSERT_TRUE(write_kitti_bin(folder / "a.bin", test::random_cloud(3, 1, 1)).ok());
  test::for_every_truncation(folder, "cut.bin", test::file_content(folder / "a.bin"),
                             [](const std::filesystem::path& path, std::size_t length) {
                               SCOPED_TRACE(length);
                               if (length % 16 == 0) {
                                 const auto cloud = read_kitti_bin(path);
                                 ASSERT_TRUE(cloud.ok());
                                 EXPECT_EQ(cloud->points.size(), length / 16);
                               } else {
                                 EXPECT_REFUSED(read_kitti_bin(path), path, "multiple of 16");
                               }
                             });
}

TEST(KittiBin, PacketRecordingsAreNamedAsSuch) {
  const TempFolder folder;
  const auto path = folder.file("a.bin", std::string(1206 * 5, 'x'));
  EXPECT_REFUSED(read_kitti_bin(path), path, "packets");
}

TEST(KittiBin, RefusesToWriteLargeOffsetsItCannotHold) {
  const TempFolder folder;
  PointCloud cloud = test::random_cloud(3, 1, 1);
  cloud.origin_y = 5e6;
  const auto written = write_kitti_bin(folder / "a.bin", cloud);
  ASSERT_FALSE(written.ok());
  EXPECT_EQ(written.error().status, Status::kUsage);
}

}  // namespace
}  // namespace planecast
