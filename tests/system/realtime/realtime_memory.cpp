// What planecastd says that it takes is what it takes, to the byte, and what does not fit is
// refused before anything is taken. The mappings are counted by the guard in the running program.
#include <gtest/gtest.h>

#include "tests/system/realtime/guarded.hpp"

namespace planecast {
namespace {

using test::Child;
using test::Guarded;
using test::number_after;
using test::operator+;
using test::Words;

const Words kConfigs[] = {
    {"sim:room:2"},
    {"sim:room:2", "--threads", "inline"},
    {"sim:room:7", "--size", "64x48", "--tolerance", "0"},
    {"sim:room:3", "--size", "1x1", "--tolerance", "0"},
    {"sim:room:9", "--size", "320x240", "--preload", "4"},
    {"sim:room:2", "--size", "1280x960", "--tolerance", "surfaces"},
    {"sim:room:3", "--size", "37x23", "--slice-bytes", "400", "--mlock"},
    {"sim:room:2", "--size", "160x120", "--slice-bytes", "30000", "--outliers", "drop"},
};

TEST(RealtimeMemory, PrintMemoryIsWhatIsMappedToTheByte) {
  for (const Words& config : kConfigs) {
    std::string shown;
    for (const std::string& word : config) shown += word + " ";
    Child plan(Words{PLANECASTD, "--print-memory"} + config);
    ASSERT_EQ(plan.wait(), 0) << shown << plan.talk();
    const long long total = number_after(plan.out(), "total");
    EXPECT_GT(number_after(plan.out(), "rest"), 1 << 20) << plan.out();
    Guarded daemon(Words{PLANECASTD, "--lcm-url", "memq://", "--rate", "50"} + config, "");
    ASSERT_EQ(daemon.child().wait(), 0) << shown << daemon.child().talk();
    EXPECT_EQ(daemon.report().mapped, total) << shown;
    std::printf("%12lld bytes mapped as stated: %s\n", total, shown.c_str());
  }
}

TEST(RealtimeMemory, WhatDoesNotFitIsRefusedBeforeTheStartWithItsFigure) {
  Child plan({PLANECASTD, "--print-memory", "sim:room:2"});
  ASSERT_EQ(plan.wait(), 0);
  const long long total = number_after(plan.out(), "total");
  const auto run = [&](const Words& command, int code, const std::string& says) {
    Child daemon(command);
    EXPECT_EQ(daemon.wait(), code) << daemon.talk();
    EXPECT_NE(daemon.talk().find(says), std::string::npos) << says << "\n" << daemon.talk();
    if (code != 0) EXPECT_EQ(daemon.talk().find("in memory"), std::string::npos) << daemon.talk();
  };
  const Words command = {PLANECASTD, "sim:room:2", "--lcm-url", "memq://"};
  run(command + Words{"--memory-limit", std::to_string(total - 1)}, 1,
      std::to_string(total) + " bytes, --memory-limit allows " + std::to_string(total - 1));
  run(command + Words{"--memory-limit", std::to_string(total)}, 0, "done");
  // Large frames, so that the program itself fits well below the limit.
  const std::string large = " sim:room:2 --size 1280x960 --lcm-url memq://";
  run({"sh", "-c", "ulimit -v 100000; exec " PLANECASTD + large}, 1,
      "bytes, RLIMIT_AS (ulimit -v)");
  Child receiver({PLANECAST_RECV, "--lcm-url", "memq://", "--memory-limit", "1M"});
  EXPECT_EQ(receiver.wait(), 1) << receiver.talk();
  EXPECT_NE(receiver.talk().find("--memory-limit allows 1048576"), std::string::npos)
      << receiver.talk();
}

// A user without privileges: every wish is refused, each with one line, and the stream runs.
TEST(RealtimeMemory, RefusedWishesCostOneWarningEach) {
  Child daemon({"setpriv", "--reuid", "65534", "--clear-groups", "--bounding-set", "-all",
                "--inh-caps", "-all", "sh", "-c",
                "ulimit -l 64; exec " PLANECASTD
                " sim:room:3 --lcm-url memq:// --mlock --fifo 10 --rate 50"});
  const int code = daemon.wait();
  const std::string talk = daemon.talk();
  if (code == 127 || talk.find("setpriv") != std::string::npos)
    GTEST_SKIP() << "setpriv cannot drop privileges here: " << talk;
  EXPECT_EQ(code, 0) << talk;
  for (const char* warning : {"memory is not locked", "SCHED_FIFO is refused"}) {
    const std::size_t at = talk.find(warning);
    ASSERT_NE(at, std::string::npos) << warning << "\n" << talk;
    EXPECT_EQ(talk.find(warning, at + 1), std::string::npos) << "said twice: " << talk;
  }
  EXPECT_EQ(number_after(talk, "frames failed"), 0) << talk;
}

}  // namespace
}  // namespace planecast

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
