// planecastd's options, files and exit codes, as scripts see them.
#include <gtest/gtest.h>

#include <fstream>
#include <string>
#include <vector>

#include "tests/system/planecastd/network/child.hpp"

namespace planecast {
namespace {

using test::Child;
using test::number_after;
using test::OwnFile;

struct Mistake {
  std::vector<std::string> command;
  int code;
  const char* says;
};

}  // namespace

TEST(DaemonOptions, MistakesEndWithTheirExitCodes) {
  const Mistake mistakes[] = {
      {{PLANECASTD}, 2, "no input given"},
      {{PLANECASTD, "sim:room:3", "--strean", "1"}, 2, "--stream"},
      {{PLANECASTD, "sim:room:3", "--stream", "256"}, 2, "--stream"},
      {{PLANECASTD, "sim:room:3", "--slice-bytes", "260"}, 2, "--slice-bytes"},
      {{PLANECASTD, "sim:room:3", "--lcm-url", "udpm//239.255.76.67:7667"}, 2, "udpm://"},
      {{PLANECASTD, "sim:room:3", "--lcm-url", "udpm://239.255.76.67:99999"}, 2, "port"},
      {{PLANECASTD, "sim:room:3", "--channel", std::string(64, 'x')}, 2, "--channel"},
      {{PLANECASTD, "sim:cellar"}, 2, "sim:room"},
      {{PLANECASTD, "lcm:"}, 2, "channel"},
      {{PLANECASTD, "lcm:A", "lcm:B"}, 2, "alone"},
      {{PLANECASTD, "no/such/folder"}, 3, "no/such/folder"},
      {{PLANECASTD, "sim:room:3", "--status", "no/such/folder/status"}, 1, "--status"},
      {{PLANECASTD, "sim:room:3", "--config", "no_such.toml"}, 3, "no_such.toml"},
      {{"unshare", "-n", PLANECASTD, "sim:room:3"}, 4, "ip route add"},
      {{"unshare", "-n", PLANECASTD, "lcm:CLOUDS"}, 4, "ip route add"},
  };
  for (const Mistake& mistake : mistakes) {
    Child daemon(mistake.command);
    EXPECT_EQ(daemon.wait(), mistake.code) << mistake.command.back() << "\n" << daemon.talk();
    EXPECT_NE(daemon.talk().find(mistake.says), std::string::npos)
        << "'" << mistake.says << "' is not in: " << daemon.talk();
    EXPECT_EQ(daemon.out(), "");
  }
}

TEST(DaemonOptions, FileAndStatusFileAreReadAndWritten) {
  const OwnFile status("status");
  const OwnFile config("config.toml");
  std::ofstream(config.path()) << "inputs = \"sim:room:4\"\nwait = true\nstatus = \""
                               << status.path() << "\"\ntolerance = \"20mm\"\n";
  for (int run = 1; run <= 2; ++run) {
    Child daemon({PLANECASTD, "--config", config.path(), "--rate", "40"});
    ASSERT_EQ(daemon.wait(), 0) << daemon.talk();
    EXPECT_EQ(number_after(daemon.talk(), "frames out"), 4) << daemon.talk();
    EXPECT_NE(daemon.talk().find("tolerance 20mm"), std::string::npos) << daemon.talk();
    EXPECT_NE(daemon.talk().find("40 Hz"), std::string::npos) << daemon.talk();
  }
  std::istringstream lines(status.text());
  int last_frames = 0;
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string keys;
    for (std::string word; words >> word;) {
      EXPECT_NO_THROW((void)std::stod(word.substr(word.find('=') + 1))) << word;
      keys += word.substr(0, word.find('=')) + " ";
    }
    EXPECT_EQ(keys, "frame hz surfaces raw_bytes packed_bytes mbit_s encode_ms dropped failed ");
    last_frames += line.starts_with("frame=3 ") ? 1 : 0;
  }
  EXPECT_GE(last_frames, 2) << "each run ends with a line on its last frame, behind the one before";
}

TEST(DaemonOptions, PrintMemoryNeedsNoNetworkAndAddsUp) {
  Child daemon({"unshare", "-n", PLANECASTD, "sim:room:7", "--print-memory"});
  ASSERT_EQ(daemon.wait(), 0) << daemon.talk();
  const std::string out = daemon.out();
  EXPECT_EQ(number_after(out, "preload"), 7 * 640 * 480 * 2) << out;
  EXPECT_EQ(number_after(out, "total"), number_after(out, "arena") + number_after(out, "stacks"))
      << out;
  Child unloaded({"unshare", "-n", PLANECASTD, "sim:room:7", "--print-memory", "--preload", "6"});
  ASSERT_EQ(unloaded.wait(), 0) << unloaded.talk();
  EXPECT_EQ(number_after(unloaded.out(), "preload"), 0) << unloaded.out();
  EXPECT_EQ(number_after(unloaded.out(), "encoder"), number_after(out, "encoder"));
}

}  // namespace planecast
