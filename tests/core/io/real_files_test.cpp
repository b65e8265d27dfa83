// Every real file of the development data that has a reader, with the counts the data state.
#include <gtest/gtest.h>

#include <algorithm>

#include "core/io/depth_png.hpp"
#include "core/io/depth_raw.hpp"
#include "core/io/file_list.hpp"
#include "core/io/point_file.hpp"
#include "tests/core/io/io_test_support.hpp"
#include "tests/support/data_path.hpp"
#include "tests/support/sanitized.hpp"

namespace planecast {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> files_with(const fs::path& root, const std::string& extension) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(root)) {
    if (entry.path().extension() == extension) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

std::size_t valid_count(const PointCloud& cloud) {
  return test::valid_points(cloud).size();
}

TEST(RealFiles, EveryPcdReadsWholeAndRoundTrips) {
  PLANECAST_NEED_SPEED();
  PLANECAST_NEED_DATA(root, ".");
  const test::TempFolder folder;
  const auto files = files_with(root, ".pcd");
  EXPECT_GE(files.size(), 52U);
  for (const fs::path& path : files) {
    SCOPED_TRACE(path.string());
    const auto cloud = read_point_file(path);
    ASSERT_TRUE(cloud.ok()) << cloud.error().message;
    EXPECT_EQ(cloud->points.size(), std::size_t{cloud->width} * cloud->height);
    EXPECT_GT(valid_count(*cloud), 300U);
    ASSERT_TRUE(write_point_file(folder / "again.pcd", *cloud).ok());
    const auto again = read_point_file(folder / "again.pcd");
    ASSERT_TRUE(again.ok());
    EXPECT_TRUE(test::same_points(again->points, cloud->points));
    EXPECT_EQ(again->width, cloud->width);
  }
}

TEST(RealFiles, EveryDepthPngReadsWithTheSensorsSize) {
  PLANECAST_NEED_DATA(root, ".");
  const auto files = files_with(root, ".png");
  EXPECT_GE(files.size(), 122U);
  for (const fs::path& path : files) {
    SCOPED_TRACE(path.string());
    const auto image = read_depth_png(path);
    ASSERT_TRUE(image.ok()) << image.error().message;
    const bool kinect2 = image->width == 512;
    EXPECT_EQ(image->height, kinect2 ? 424U : 480U);
    const auto holes = std::count(image->depth.begin(), image->depth.end(), 0);
    EXPECT_LT(static_cast<double>(holes), 0.25 * static_cast<double>(image->depth.size()));
  }
}

TEST(RealFiles, TheStairDepthIsTheCloudsDistanceInMillimetres) {
  PLANECAST_NEED_DATA(folder, "depth_frames/stair_kinect2");
  const auto image = read_depth_png(folder / "0000_depth.png");
  const auto cloud = read_point_file(folder / "0000_cloud.pcd");
  ASSERT_TRUE(image.ok() && cloud.ok());
  // The cloud is the depth turned to gravity: lengths of the rays survive the turn (MANIFEST:
  // f 365.31, c (254.68, 208.55)).
  std::size_t compared = 0;
  for (std::size_t i = 0; i < cloud->points.size(); ++i) {
    if (image->depth[i] == 0) continue;
    const Point3f& p = cloud->points[i];
    const double z = image->depth[i] * 1e-3;
    const double u = (static_cast<double>(i % 512) - 254.68) / 365.31;
    const double v = (static_cast<double>(i / 512) - 208.55) / 365.31;
    const double length = std::sqrt(p.x * p.x + p.y * p.y + p.z * p.z);
    ASSERT_NEAR(length, z * std::sqrt(u * u + v * v + 1), 1e-3) << i;
    ++compared;
  }
  EXPECT_EQ(compared, 178611U);
}

TEST(RealFiles, RawDepthHasTheStatedShareOfReadings) {
  PLANECAST_NEED_DATA(folder, "depth_frames/azure_kinect_zdepth");
  const auto files = files_with(folder, ".raw");
  EXPECT_EQ(files.size(), 6U);
  for (const fs::path& path : files) {
    const auto image = read_depth_raw(path, 320, 288);
    ASSERT_TRUE(image.ok()) << image.error().message;
    const auto holes = std::count(image->depth.begin(), image->depth.end(), 0);
    const double valid = 1 - static_cast<double>(holes) / (320.0 * 288.0);
    EXPECT_GT(valid, 0.69);  // MANIFEST: 70 to 77 % valid
    EXPECT_LT(valid, 0.78);
  }
}

struct Stated {
  const char* path;
  std::size_t least;
  std::size_t most;
};

TEST(RealFiles, ValidPointsAreAsManyAsStated) {
  PLANECAST_NEED_DATA(root, ".");
  for (const Stated& stated : {
           Stated{"depth_frames/pcl_grabber_kinect1/frame_20121214T142255.814212.pcd", 270000,
                  272500},
           Stated{"depth_frames/pcl_misc/region_growing_rgb_tutorial.pcd", 259000, 261000},
           Stated{"depth_frames/stair_kinect2/0000_cloud.pcd", 150000, 217088},
           Stated{"unit/bunny.pcd", 397, 397},
           Stated{"unit/colored_cloud.pcd", 1000, 1000},
           Stated{"unit/sac_plane_test.pcd", 3283, 3283},
           Stated{"unit/lamppost.pcd", 1771, 1771},
           Stated{"unit/min_cut_segmentation_tutorial.pcd", 9311, 9311},
           Stated{"unit/samp24-utm.pcd", 7492, 7492},
           Stated{"unorganised/pcl/cturtle.pcd", 166000, 167198},
           Stated{"unorganised/itsme_trees/tree_2_pc.txt", 51750, 51751},
           Stated{"unorganised/itsme_trees/buttressed_tree_1_pc.txt", 64082, 64083},
           Stated{"unorganised/itsme_trees/pc_tree_uav.txt", 67231, 67232},
       }) {
    SCOPED_TRACE(stated.path);
    const auto cloud = read_point_file(root / stated.path);
    ASSERT_TRUE(cloud.ok()) << cloud.error().message;
    EXPECT_GE(valid_count(*cloud), stated.least);
    EXPECT_LE(valid_count(*cloud), stated.most);
  }
}

TEST(RealFiles, KinectDepthLiesOnWholeMillimetres) {
  PLANECAST_NEED_DATA(path, "depth_frames/pcl_misc/office1.pcd");
  const auto cloud = read_point_file(path);
  ASSERT_TRUE(cloud.ok()) << cloud.error().message;
  EXPECT_EQ(cloud->width, 640U);
  EXPECT_EQ(cloud->height, 480U);
  EXPECT_EQ(cloud->dropped_fields, std::vector<std::string>{"rgb"});
  EXPECT_EQ(cloud->viewpoint.qx, 1);
  for (const Point3f& p : cloud->points) {
    if (test::is_hole(p)) continue;
    ASSERT_NEAR(p.z * 1e3F, std::round(p.z * 1e3F), 2e-3F);
  }
}

TEST(RealFiles, FoldersExpandAsAPersonExpects) {
  PLANECAST_NEED_DATA(root, ".");
  const auto expand = [&root](const std::string& folder) {
    const std::vector<std::string> inputs = {(root / folder).string()};
    return expand_inputs(inputs);
  };
  const auto sequence = expand("depth_seq/aims_realsense");
  ASSERT_TRUE(sequence.ok()) << sequence.error().message;
  ASSERT_EQ(sequence->size(), 120U);
  EXPECT_EQ((*sequence)[2].filename(), "2.png");
  EXPECT_EQ((*sequence)[119].filename(), "119.png");
  const auto grabber = expand("depth_frames/pcl_grabber_kinect1");
  ASSERT_TRUE(grabber.ok()) << grabber.error().message;
  EXPECT_EQ(grabber->size(), 3U);
  EXPECT_REFUSED(expand("depth_frames/stair_kinect2"), root / "depth_frames/stair_kinect2",
                 "several kinds");
  const auto packets = root / "lidar_seq/vlp16_dual_florian/vlp16_0.bin";
  EXPECT_REFUSED(read_point_file(packets), packets, "packets");
}

}  // namespace
}  // namespace planecast
