// Runs the planecast command in a folder of its own, and makes small frames for it.
#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "core/base/random.hpp"
#include "core/io/depth_png.hpp"
#include "core/io/depth_raw.hpp"
#include "core/io/file_bytes.hpp"
#include "core/io/pcd.hpp"
#include "core/sim/sim_room.hpp"

namespace planecast::test {

namespace fs = std::filesystem;

/// What a run gave.
struct RunResult {
  int code = -1;
  std::string out;
  std::string talk;
  bool says(const std::string& part) const { return talk.find(part) != std::string::npos; }
  nlohmann::json json() const { return nlohmann::json::parse(out); }
};

/// The camera of small_frame().
inline constexpr const char* kSmallCamera = " --camera 95.75,95.75,79.5,59.5,0.001";

class CommandTest : public testing::Test {
 protected:
  void SetUp() override {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::path(testing::TempDir()) / ("planecast_" + std::string(test->test_suite_name()) +
                                              "_" + test->name() + "_" + std::to_string(getpid()));
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    unsetenv("LCM_DEFAULT_URL");
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path at(const std::string& name) const { return folder_ / name; }

  /// Runs `planecast ARGUMENTS` with the test's folder as working directory.
  RunResult run(const std::string& arguments) const {
    const std::string command = "cd '" + folder_.string() + "' && '" PLANECAST_COMMAND "' " +
                                arguments + " > .out 2> .talk";
    const int status = std::system(command.c_str());
    RunResult result;
    result.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    result.out = text_of(".out");
    result.talk = text_of(".talk");
    return result;
  }

  std::string text_of(const std::string& name) const {
    std::ifstream file(at(name));
    std::stringstream text;
    text << file.rdbuf();
    return text.str();
  }

  std::vector<std::uint8_t> bytes_of(const std::string& name) const {
    return read_file_bytes(at(name)).value();
  }
  void write_bytes(const std::string& name, const std::vector<std::uint8_t>& bytes) const {
    ASSERT_TRUE(write_file_bytes(at(name), bytes).ok());
  }
  void write_text(const std::string& name, const std::string& text) const {
    ASSERT_TRUE(write_file_text(at(name), text).ok());
  }
  void write_png(const std::string& name, const DepthImage& image) const {
    ASSERT_TRUE(write_depth_png(at(name), image).ok());
  }
  void write_cloud(const std::string& name, const PointCloud& cloud) const {
    ASSERT_TRUE(write_pcd(at(name), cloud).ok());
  }

  /// Names of the folder's entries that begin with a dot but are not the runner's own.
  std::vector<std::string> hidden_files() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder_)) {
      const std::string name = entry.path().filename().string();
      if (name.front() == '.' && name != ".out" && name != ".talk") names.push_back(name);
    }
    return names;
  }

 private:
  fs::path folder_;
};

/// A 160 x 120 frame of the simulated room, as a D435 would see it.
inline DepthImage small_frame(std::uint64_t number) {
  SimConfig config = default_sim_config();
  config.width = 160;
  config.height = 120;
  config.intrinsics.fx = config.intrinsics.fy = 95.75;
  config.intrinsics.cx = 79.5;
  config.intrinsics.cy = 59.5;
  auto simulator = RoomSimulator::create(config);
  DepthImage image;
  std::vector<std::uint16_t> truth;
  Pose pose;
  simulator->render(number, image, truth, pose);
  return image;
}

/// The cloud of a depth image in millimetres by a pinhole camera, in optical axes.
inline PointCloud cloud_of(const DepthImage& image, float focal, float cx, float cy) {
  PointCloud cloud;
  cloud.width = image.width;
  cloud.height = image.height;
  constexpr float kHole = std::numeric_limits<float>::quiet_NaN();
  for (std::uint32_t v = 0; v < image.height; ++v) {
    for (std::uint32_t u = 0; u < image.width; ++u) {
      const std::uint16_t count = image.depth[std::size_t{v} * image.width + u];
      const float z = static_cast<float>(count * 0.001);
      const Point3f p{(static_cast<float>(u) - cx) * z / focal,
                      (static_cast<float>(v) - cy) * z / focal, z};
      cloud.points.push_back(count == 0 ? Point3f{kHole, kHole, kHole} : p);
    }
  }
  return cloud;
}

inline bool is_hole(const Point3f& p) {
  return std::isnan(p.x) || std::isnan(p.y) || std::isnan(p.z);
}

}  // namespace planecast::test
