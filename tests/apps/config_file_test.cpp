#include "apps/common/config_file.hpp"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "tests/apps/command_fixture.hpp"

namespace planecast {
namespace {

using test::Command;
using ConfigFile = test::CommandLine;

TEST_F(ConfigFile, FlagBeatsEnvironmentBeatsFileBeatsDefault) {
  const std::string config = file("tolerance = \"30mm\"\nk = 11\nrate = 15\n");
  set("PLANECAST_TOLERANCE", "20mm");
  set("PLANECAST_K", "12");
  Command c;
  ASSERT_FALSE(c.run({"--config", config.c_str(), "--tolerance", "10mm"})) << c.talk;
  EXPECT_EQ(to_string(c.options.tolerance), "10mm");
  EXPECT_EQ(c.options.k, 12U);
  EXPECT_DOUBLE_EQ(*c.options.rate_hz, 15.0);
  EXPECT_EQ(c.options.slice_bytes, 1200U);
  EXPECT_TRUE(c.options.is_given("rate"));
  EXPECT_FALSE(c.options.is_given("slice-bytes"));
}

TEST_F(ConfigFile, TheEnvironmentMayNameTheFile) {
  set("PLANECAST_CONFIG", file("k = 11\n"));
  Command c;
  ASSERT_FALSE(c.run({})) << c.talk;
  EXPECT_EQ(c.options.k, 11U);
}

TEST_F(ConfigFile, AFileSetsInputsFlagsListsAndUnderscores) {
  const std::string config = file(
      "# a comment\n"
      "input = [\"a.png\", \"b.png\"]\n"
      "camera = [525, 525, 319.5, 239.5, 0.001]\n"
      "tolerance = \"surfaces\"\n"
      "off_surface = \"drop\"\n"
      "json = true\n"
      "out = \"x.plc\"\n");
  Command c;
  ASSERT_FALSE(c.run({"--config", config.c_str()})) << c.talk;
  EXPECT_EQ(c.input, (std::vector<std::string>{"a.png", "b.png"}));
  EXPECT_DOUBLE_EQ(c.options.camera->intrinsics.cx, 319.5);
  EXPECT_EQ(c.options.off_surface, OffSurface::kDrop);
  EXPECT_TRUE(c.json);
  EXPECT_EQ(c.out, "x.plc");
}

TEST_F(ConfigFile, AFlagSetToFalseInAFileStaysOff) {
  const std::string config = file("json = false\n");
  Command c;
  ASSERT_FALSE(c.run({"--config", config.c_str()})) << c.talk;
  EXPECT_FALSE(c.json);
}

TEST_F(ConfigFile, AnUnknownKeyNamesFileLineAndTheNearestKey) {
  const std::string config = file("k = 30\n\ntolerence = \"10mm\"\n");
  Command c;
  EXPECT_EQ(c.run({"--config", config.c_str()}), ExitCode::kUsage);
  EXPECT_TRUE(c.says(config + ":3: unknown key 'tolerence'; did you mean 'tolerance'?")) << c.talk;
}

TEST_F(ConfigFile, ABadValueInAFileNamesFileLineAndOption) {
  const std::string config = file("k = 30\nrange = \"10\"\n");
  Command c;
  EXPECT_EQ(c.run({"--config", config.c_str()}), ExitCode::kUsage);
  EXPECT_TRUE(c.says(config + ":2: --range: '10' is not MIN,MAX")) << c.talk;
}

TEST_F(ConfigFile, BrokenFilesNameTheLine) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"k = 30\nrange = \n", ":2: "},
      {"k = 30\n[sensor]\nrange = \"1,2\"\n", ":2: 'sensor' is neither"},
      {"off-surface = \"keep\"\noff_surface = \"keep\"\n", "'off-surface' is set twice"},
      {"k = 1979-05-27\n", ":1: 'k' is neither"},
      {"k = [[1]]\n", ":1: 'k' is neither"},
  };
  for (const auto& [text, message] : cases) {
    const std::string config = file(text);
    Command c;
    EXPECT_EQ(c.run({"--config", config.c_str()}), ExitCode::kUsage) << text;
    EXPECT_TRUE(c.says(config)) << c.talk;
    EXPECT_TRUE(c.says(message)) << c.talk;
  }
}

TEST_F(ConfigFile, AFileThatIsNotThereIsBadInput) {
  Command c;
  EXPECT_EQ(c.run({"--config", "no/such/file.toml"}), ExitCode::kBadInput);
  EXPECT_TRUE(c.says("no/such/file.toml: no such configuration file")) << c.talk;
  Command folder;
  const std::string temp = testing::TempDir();
  EXPECT_EQ(folder.run({"--config", temp.c_str()}), ExitCode::kBadInput);
}

}  // namespace
}  // namespace planecast
