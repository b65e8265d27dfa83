#include "core/io/point_file.hpp"

#include <gtest/gtest.h>

#include "tests/core/io/io_test_support.hpp"

namespace planecast {
namespace {

using test::TempFolder;

TEST(PointFile, EveryWritableExtensionReadsBackTheSame) {
  const TempFolder folder;
  const PointCloud cloud = test::random_cloud(100, 1, 6);
  for (const char* name : {"a.pcd", "a.PLY", "a.bin", "a.xyz", "a.txt", "a.asc"}) {
    SCOPED_TRACE(name);
    const auto written = write_point_file(folder / name, cloud);
    ASSERT_TRUE(written.ok()) << written.error().message;
    const auto read = read_point_file(folder / name);
    ASSERT_TRUE(read.ok()) << read.error().message;
    EXPECT_TRUE(test::same_points(read->points, cloud.points));
  }
}

TEST(PointFile, FormatsNotReadAreRefusedByNameWithTheMend) {
  const TempFolder folder;
  for (const auto& [name, message] : {std::pair{"a.tiff", "TIFF"},
                                      {"a.las", "LAS"},
                                      {"a.LAZ", "LAZ"},
                                      {"a.pclzf", "PCLZF"},
                                      {"a.e57", "E57"},
                                      {"a.db3", "rosbag2"},
                                      {"a.mcap", "MCAP"},
                                      {"a.pcap", "packet"},
                                      {"a.plc", "planecast decode"},
                                      {"a.foo", "'.foo'"},
                                      {"a", "no extension"},
                                      {"a.png", "depth image"},
                                      {"a.raw", "depth image"}}) {
    const auto path = folder.file(name, "whatever");
    EXPECT_REFUSED(read_point_file(path), path, message);
  }
}

TEST(PointFile, FormatsNotWrittenAreAUsageError) {
  const TempFolder folder;
  for (const char* name : {"a.las", "a.csv", "a.png", "a"}) {
    const auto written = write_point_file(folder / name, test::random_cloud(2, 1, 1));
    ASSERT_FALSE(written.ok());
    EXPECT_EQ(written.error().status, Status::kUsage);
    EXPECT_FALSE(std::filesystem::exists(folder / name));
  }
}

TEST(PointFile, AMissingFileIsMissingWhateverItsKind) {
  const TempFolder folder;
  for (const char* name : {"none.pcd", "none.las", "none.png"}) {
    const auto read = read_point_file(folder / name);
    ASSERT_FALSE(read.ok());
    EXPECT_EQ(read.error().status, Status::kNotFound);
  }
}

}  // namespace
}  // namespace planecast
