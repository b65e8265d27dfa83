// The command on recorded frames, where the development data are at hand: exact depth, bounds that
// hold, and sizes that stay where they were promised.
#include "tests/apps/planecast/command_runner.hpp"
#include "tests/support/data_path.hpp"
#include "tests/support/sanitized.hpp"

namespace planecast::test {
namespace {

class RealFrames : public CommandTest {
 protected:
  // Figures of one file; the exit code says whether every point kept its bound.
  nlohmann::json frame_of(const fs::path& file, const std::string& options) const {
    const RunResult result = run("eval '" + file.string() + "' " + options + " --json");
    EXPECT_EQ(result.code, 0) << file << " " << options << "\n" << result.talk;
    return result.code == 0 ? result.json()["frames"][0] : nlohmann::json::object();
  }
};

TEST_F(RealFrames, RealSenseStaysWithinItsSizesAtEachTolerance) {
  PLANECAST_NEED_SPEED();
  PLANECAST_NEED_DATA(file, "depth_seq/aims_realsense/0.png");
  const std::string options =
      "--camera 383.8,383.8,321.7,236.8,0.001 --range 0.2,10 --noise stereo:0.003 --tolerance ";
  const auto bits = [&](const std::string& tolerance) {
    return frame_of(file, options + tolerance)["bits_per_point"].get<double>();
  };
  EXPECT_LE(bits("0"), 1.8);
  EXPECT_LE(bits("10mm"), 1.0);
  EXPECT_LE(bits("2sigma"), 0.65);
  const auto planes = frame_of(file, options + "surfaces --off-surface drop");
  EXPECT_LE(planes["bits_per_point"], 0.25);
  EXPECT_GE(planes["points_out"].get<double>(), 0.6 * planes["points_in"].get<double>());
}

TEST_F(RealFrames, DepthComesBackExactWithoutARange) {
  PLANECAST_NEED_SPEED();
  PLANECAST_NEED_DATA(realsense, "depth_seq/aims_realsense/60.png");
  PLANECAST_NEED_DATA(stairs, "depth_frames/stair_kinect2/0000_depth.png");
  PLANECAST_NEED_DATA(azure, "depth_frames/azure_kinect_zdepth/room0_320x288_u16le.raw");
  for (const fs::path& file : {realsense, stairs, azure})
    EXPECT_EQ(frame_of(file, "--size 320x288 --tolerance 0")["max_mm"], 0.0) << file;
}

TEST_F(RealFrames, CloudsFindTheirCameraAndKeepTheirBound) {
  PLANECAST_NEED_SPEED();
  PLANECAST_NEED_DATA(kinect, "depth_frames/pcl_misc/office1.pcd");
  PLANECAST_NEED_DATA(stereo, "depth_frames/pcl_misc/table_scene_mug_stereo_textured.pcd");
  EXPECT_LE(frame_of(kinect, "--tolerance 0")["bits_per_point"], 1.5);
  EXPECT_LE(frame_of(kinect, "--tolerance 2sigma")["bits_per_point"], 0.5);
  EXPECT_LE(frame_of(stereo, "--tolerance 10mm")["bits_per_point"], 0.5);
  EXPECT_EQ(frame_of(stereo, "--tolerance 0")["max_mm"], 0.0);
}

}  // namespace
}  // namespace planecast::test
