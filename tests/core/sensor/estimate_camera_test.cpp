// Estimating the camera of a cloud: synthetic clouds with every kind of pose, then real recordings.
#include "core/sensor/estimate_camera.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "core/base/random.hpp"
#include "core/io/pcd.hpp"
#include "core/sensor/ray_table.hpp"
#include "core/sensor/z_grid.hpp"
#include "tests/support/data_path.hpp"

namespace planecast {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
using Matrix = std::array<double, 9>;
constexpr Matrix kIdentity{1, 0, 0, 0, 1, 0, 0, 0, 1};

struct Scene {
  double fx = 300, fy = 305, cx = 81.3, cy = 57.9;
  Matrix axes = kIdentity;  // cloud_from_optical, may mirror
  std::array<double, 3> shift{0, 0, 0};
  double strays = 0;  // share of points that are not on their ray
};

// A bumpy scene 1 to 4 m away with 10 % holes.
PointCloud make_cloud(const Scene& scene) {
  Pcg32 random(21);
  PointCloud cloud;
  cloud.width = 160;
  cloud.height = 120;
  for (int v = 0; v < 120; ++v) {
    for (int u = 0; u < 160; ++u) {
      const double z = 2.5 + std::sin(u * 0.05) + 0.5 * std::cos(v * 0.11);
      double q[3] = {z * (u - scene.cx) / scene.fx, z * (v - scene.cy) / scene.fy, z};
      if (random.uniform() < scene.strays) q[0] += 0.1 * random.uniform();
      float p[3];
      for (int i = 0; i < 3; ++i) {
        const double* row = &scene.axes[static_cast<std::size_t>(3 * i)];
        p[i] = static_cast<float>(row[0] * q[0] + row[1] * q[1] + row[2] * q[2] +
                                  scene.shift[static_cast<std::size_t>(i)]);
      }
      const bool hole = random.uniform() < 0.1;
      cloud.points.push_back(hole ? Point3f{kNan, kNan, kNan} : Point3f{p[0], p[1], p[2]});
    }
  }
  return cloud;
}

Matrix turned(double yaw, double pitch) {
  const double cy = std::cos(yaw), sy = std::sin(yaw), cp = std::cos(pitch), sp = std::sin(pitch);
  return {cy, sy * sp, sy * cp, 0, cp, -sp, -sy, cy * sp, cy * cp};
}

void expect_intrinsics(const EstimatedCamera& camera, const Scene& scene, double tolerance_px) {
  EXPECT_NEAR(camera.intrinsics.fx, scene.fx, tolerance_px);
  EXPECT_NEAR(camera.intrinsics.fy, scene.fy, tolerance_px);
  EXPECT_NEAR(camera.intrinsics.cx, scene.cx, tolerance_px);
  EXPECT_NEAR(camera.intrinsics.cy, scene.cy, tolerance_px);
}

// Where the fitted camera puts an optical point; with `scene` it must agree with make_cloud.
std::array<double, 3> place(const EstimatedCamera& camera, double x, double y, double z) {
  const Pose& p = camera.cloud_from_optical;
  if (camera.mirror_y) y = -y;
  const double w = p.qw, a = p.qx, b = p.qy, c = p.qz;
  return {(1 - 2 * (b * b + c * c)) * x + 2 * (a * b - w * c) * y + 2 * (a * c + w * b) * z + p.tx,
          2 * (a * b + w * c) * x + (1 - 2 * (a * a + c * c)) * y + 2 * (b * c - w * a) * z + p.ty,
          2 * (a * c - w * b) * x + 2 * (b * c + w * a) * y + (1 - 2 * (a * a + b * b)) * z + p.tz};
}

void expect_axes(const EstimatedCamera& camera, const Scene& scene) {
  const double points[3][3] = {{1, 0, 2}, {0, 1, 2}, {-1, -1, 3}};
  for (const auto& q : points) {
    const auto p = place(camera, q[0], q[1], q[2]);
    for (std::size_t i = 0; i < 3; ++i) {
      const double* row = &scene.axes[3 * i];
      EXPECT_NEAR(p[i], row[0] * q[0] + row[1] * q[1] + row[2] * q[2] + scene.shift[i], 1e-4);
    }
  }
}

TEST(EstimateCamera, FindsAnOpticalCloudsIntrinsics) {
  const Scene scene;
  const auto camera = estimate_camera(make_cloud(scene));
  ASSERT_TRUE(camera.ok());
  EXPECT_EQ(camera->model, EstimatedCamera::Model::kPinhole);
  EXPECT_FALSE(camera->mirror_y);
  expect_intrinsics(*camera, scene, 1e-3);
  EXPECT_LT(camera->max_residual_m, 1e-6);
  EXPECT_EQ(camera->inliers, camera->points);
}

TEST(EstimateCamera, FindsATurnedCloud) {
  for (const Matrix& axes : {turned(0.3, -0.4), turned(-2.5, 1.1), turned(0.001, 0.0),
                             Matrix{0, 0, 1, -1, 0, 0, 0, -1, 0},     // robot: x forward, z up
                             Matrix{1, 0, 0, 0, -1, 0, 0, 0, -1}}) {  // OpenGL: y up, z backward
    Scene scene;
    scene.axes = axes;
    const auto camera = estimate_camera(make_cloud(scene));
    ASSERT_TRUE(camera.ok());
    EXPECT_EQ(camera->model, EstimatedCamera::Model::kRotated);
    EXPECT_FALSE(camera->mirror_y);
    expect_intrinsics(*camera, scene, 0.01);
    expect_axes(*camera, scene);
    EXPECT_LT(camera->max_residual_m, 2e-6);
  }
}

TEST(EstimateCamera, FindsLeftHandedAxes) {
  for (const Matrix& axes : {Matrix{1, 0, 0, 0, -1, 0, 0, 0, 1}, Matrix{-1, 0, 0, 0, 1, 0, 0, 0, 1},
                             Matrix{0, 0, 1, 1, 0, 0, 0, -1, 0}}) {
    Scene scene;
    scene.axes = axes;
    const auto camera = estimate_camera(make_cloud(scene));
    ASSERT_TRUE(camera.ok());
    EXPECT_TRUE(camera->mirror_y);
    expect_intrinsics(*camera, scene, 0.01);
    expect_axes(*camera, scene);
    EXPECT_LT(camera->max_residual_m, 2e-6);
  }
}

TEST(EstimateCamera, FindsAMovedViewpoint) {
  Scene scene;
  scene.axes = turned(0.7, 0.2);
  scene.shift = {1.5, -0.4, 0.9};
  const auto camera = estimate_camera(make_cloud(scene));
  ASSERT_TRUE(camera.ok());
  EXPECT_EQ(camera->model, EstimatedCamera::Model::kMoved);
  expect_intrinsics(*camera, scene, 0.05);
  expect_axes(*camera, scene);
  EXPECT_LT(camera->max_residual_m, 5e-6);
}

TEST(EstimateCamera, IgnoresAFifthOfPointsThatAreOffTheirRays) {
  Scene scene;
  scene.axes = turned(0.3, -0.4);
  scene.strays = 0.2;
  const auto camera = estimate_camera(make_cloud(scene));
  ASSERT_TRUE(camera.ok());
  expect_intrinsics(*camera, scene, 0.01);
  EXPECT_GT(camera->max_residual_m, 0.05);
  EXPECT_LT(camera->inlier_max_residual_m, 6e-6);
  EXPECT_NEAR(static_cast<double>(camera->inliers), 0.8 * static_cast<double>(camera->points),
              0.03 * static_cast<double>(camera->points));
}

TEST(EstimateCamera, SaysThatACloudOfNoPinholeHasALargeResidual) {
  PointCloud cloud;  // a spinning scanner: equal angles, all around
  cloud.width = 360;
  cloud.height = 32;
  for (int v = 0; v < 32; ++v) {
    for (int u = 0; u < 360; ++u) {
      const double a = u * 3.14159265 / 180, e = (v - 16) * 0.02, r = 5 + std::sin(0.1 * u);
      cloud.points.push_back({static_cast<float>(r * std::cos(e) * std::cos(a)),
                              static_cast<float>(r * std::cos(e) * std::sin(a)),
                              static_cast<float>(r * std::sin(e))});
    }
  }
  const auto camera = estimate_camera(cloud);
  if (camera.ok()) {
    EXPECT_GT(camera->max_residual_m, 0.5);
  }
}

TEST(EstimateCamera, RefusesWhatTellsNothingAndSaysToGiveTheCamera) {
  PointCloud holes = make_cloud(Scene{});
  for (Point3f& p : holes.points) p = {kNan, kNan, kNan};
  PointCloud row = make_cloud(Scene{});
  for (std::size_t i = 0; i < row.points.size(); ++i) {
    if (i / 160 != 60) row.points[i] = {kNan, kNan, kNan};
  }
  PointCloud list = make_cloud(Scene{});
  list.width *= list.height;
  list.height = 1;
  for (const PointCloud& cloud : {holes, row, list, PointCloud{}}) {
    const auto camera = estimate_camera(cloud);
    ASSERT_FALSE(camera.ok()) << camera->describe();
    EXPECT_NE(camera.error().message.find("--camera"), std::string::npos);
  }
}

// x and y of every point from the wire's rays and the float z; the largest error in metres.
double table_error(const PointCloud& cloud, const Intrinsics& intrinsics) {
  const CameraModel model = *quantise(intrinsics, cloud.width, cloud.height);
  std::vector<std::int32_t> storage(ray_table_entries(model));
  RayTable rays;
  EXPECT_EQ(build_ray_table(model, storage, rays), Status::kOk);
  double worst = 0;
  for (std::uint32_t v = 0; v < cloud.height; ++v) {
    for (std::uint32_t u = 0; u < cloud.width; ++u) {
      const Point3f& p = cloud.points[std::size_t{v} * cloud.width + u];
      if (std::isnan(p.z)) continue;
      const auto x = static_cast<float>(p.z * (rays.x(u, v) * 0x1p-27));
      const auto y = static_cast<float>(p.z * (rays.y(u, v) * 0x1p-27));
      worst = std::max({worst, std::abs(double{x} - p.x), std::abs(double{y} - p.y)});
    }
  }
  return worst;
}

TEST(EstimateCamera, ProvesEveryKinectRecording) {
  const struct {
    const char* file;
    double cx, cy;
  } recordings[] = {
      {"pcl_grabber_kinect1/frame_20121214T142255.814212.pcd", 320, 240},
      {"pcl_grabber_kinect1/frame_20121214T142256.068683.pcd", 320, 240},
      {"pcl_grabber_kinect1/frame_20121214T142256.332395.pcd", 320, 240},
      {"pcl_pairwise_kinect1/capture0001.pcd", 319.5, 239.5},
      {"pcl_pairwise_kinect1/capture0002.pcd", 319.5, 239.5},
      {"pcl_pairwise_kinect1/capture0003.pcd", 319.5, 239.5},
      {"pcl_pairwise_kinect1/capture0004.pcd", 319.5, 239.5},
      {"pcl_pairwise_kinect1/capture0005.pcd", 319.5, 239.5},
      {"pcl_misc/office1.pcd", 320, 240},
      {"pcl_misc/region_growing_rgb_tutorial.pcd", 320, 240},
      {"pcl_misc/five_people.pcd", 319.5, 239.5},
      {"pcl_misc/milk_cartoon_all_small_clorox.pcd", 319.5, 239.5},
  };
  for (const auto& recording : recordings) {
    SCOPED_TRACE(recording.file);
    PLANECAST_NEED_DATA(path, std::string("depth_frames/") + recording.file);
    const auto cloud = read_pcd(path);
    ASSERT_TRUE(cloud.ok()) << cloud.error().message;
    const auto grid = find_z_grid(*cloud);
    ASSERT_TRUE(grid.has_value());
    EXPECT_EQ(grid->unit_pm, 1'000'000'000U);
    const auto camera = estimate_camera(*cloud);
    ASSERT_TRUE(camera.ok());
    EXPECT_EQ(camera->model, EstimatedCamera::Model::kPinhole);
    EXPECT_NEAR(camera->intrinsics.fx, 525, 0.01);
    EXPECT_NEAR(camera->intrinsics.fy, 525, 0.01);
    EXPECT_NEAR(camera->intrinsics.cx, recording.cx, 0.01);
    EXPECT_NEAR(camera->intrinsics.cy, recording.cy, 0.01);
    EXPECT_LT(table_error(*cloud, camera->intrinsics), 2e-6);
  }
}

TEST(EstimateCamera, FitsThePrintedStereoCloudThatHasNoGrid) {
  PLANECAST_NEED_DATA(path, "depth_frames/pcl_misc/table_scene_mug_stereo_textured.pcd");
  const auto cloud = read_pcd(path);
  ASSERT_TRUE(cloud.ok()) << cloud.error().message;
  EXPECT_FALSE(find_z_grid(*cloud).has_value());
  const auto camera = estimate_camera(*cloud);
  ASSERT_TRUE(camera.ok());
  EXPECT_NEAR(camera->intrinsics.fx, 964.36, 0.01);
  EXPECT_NEAR(camera->intrinsics.cx, 319.81, 0.01);
  EXPECT_NEAR(camera->intrinsics.cy, 223.36, 0.01);
  EXPECT_LT(camera->max_residual_m, 30e-6);  // five printed digits
}

// A sixth of these clouds' points, where the depth image has no reading, lie up to 0.6 m off their
// rays; the rest fit to float rounding.
TEST(EstimateCamera, FitsCloudsTurnedToGravity) {
  for (const char* file : {"0000_cloud.pcd", "0001_cloud.pcd"}) {
    PLANECAST_NEED_DATA(path, std::string("depth_frames/stair_kinect2/") + file);
    const auto cloud = read_pcd(path);
    ASSERT_TRUE(cloud.ok()) << cloud.error().message;
    const auto camera = estimate_camera(*cloud);
    ASSERT_TRUE(camera.ok());
    EXPECT_EQ(camera->model, EstimatedCamera::Model::kRotated);
    EXPECT_NEAR(camera->intrinsics.fx, 365.31, 0.02);
    EXPECT_NEAR(camera->intrinsics.cx, 254.68, 0.02);
    EXPECT_NEAR(camera->intrinsics.cy, 208.55, 0.02);
    EXPECT_GT(camera->inliers, camera->points * 8 / 10);
    EXPECT_LT(camera->inlier_max_residual_m, 6e-6);
  }
}

}  // namespace
}  // namespace planecast
