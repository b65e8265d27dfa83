#include "apps/common/command_line.hpp"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "tests/apps/command_fixture.hpp"

namespace planecast {
namespace {

using test::Command;
using CommandLine = test::CommandLine;

TEST_F(CommandLine, DefaultsAreThoseThatHelpStates) {
  Command c;
  ASSERT_FALSE(c.run({"in.png"}));
  EXPECT_EQ(c.input, std::vector<std::string>{"in.png"});
  EXPECT_EQ(to_string(c.options.tolerance), "2sigma");
  EXPECT_EQ(c.options.slice_bytes, 1200U);
  EXPECT_EQ(c.options.off_surface, OffSurface::kKeep);
  EXPECT_EQ(c.options.threads, Threads::kPipeline);
  EXPECT_FALSE(c.options.camera);
  EXPECT_FALSE(c.options.rate_hz);
  EXPECT_TRUE(c.options.given.empty());
}

TEST_F(CommandLine, ReadsEverySharedOption) {
  Command c;
  ASSERT_FALSE(c.run({"--camera",
                      "383.8,383.8,321.7,236.8,0.001",
                      "--distortion",
                      "-0.05,0.06,0,0",
                      "--size",
                      "640x480",
                      "--units",
                      "0.001",
                      "--lidar",
                      "VLP-16",
                      "--range",
                      "0.2,10",
                      "--noise",
                      "stereo:0.003",
                      "--tolerance",
                      "surfaces:2",
                      "--off-surface",
                      "drop",
                      "--outliers",
                      "drop",
                      "--method",
                      "paper",
                      "--regenerate",
                      "lattice",
                      "--alpha",
                      "5cm",
                      "--smoothness",
                      "4.5",
                      "--k",
                      "12",
                      "--effort",
                      "best",
                      "--budget-ms",
                      "20",
                      "--slice-bytes",
                      "1000",
                      "--rate",
                      "30",
                      "--repeat",
                      "0",
                      "--lcm-url",
                      "udpm://239.1.2.3:7000?ttl=1",
                      "--seed",
                      "42",
                      "--threads",
                      "inline",
                      "--name",
                      "front",
                      "--channel",
                      "CLOUD_FRONT",
                      "in"}))
      << c.talk;
  const CodecOptions& o = c.options;
  EXPECT_DOUBLE_EQ(o.camera->intrinsics.cx, 321.7);
  EXPECT_DOUBLE_EQ(intrinsics_of(o)->k1, -0.05);
  EXPECT_EQ(o.size->height, 480U);
  EXPECT_DOUBLE_EQ(*o.units_m, 0.001);
  EXPECT_EQ(o.lidar, "VLP-16");
  EXPECT_DOUBLE_EQ(o.range->max_m, 10.0);
  EXPECT_EQ(noise_or_preset(o)->kind, NoiseModel::Kind::kStereo);
  EXPECT_EQ(to_string(o.tolerance), "surfaces:2");
  EXPECT_EQ(o.off_surface, OffSurface::kDrop);
  EXPECT_EQ(o.outliers, Outliers::kDrop);
  EXPECT_EQ(o.method, Method::kPaper);
  EXPECT_EQ(o.regenerate, Regenerate::kLattice);
  EXPECT_DOUBLE_EQ(o.alpha_m, 0.05);
  EXPECT_DOUBLE_EQ(o.smoothness_deg, 4.5);
  EXPECT_EQ(o.k, 12U);
  EXPECT_EQ(o.effort, Effort::kBest);
  EXPECT_DOUBLE_EQ(*o.budget_ms, 20.0);
  EXPECT_EQ(o.slice_bytes, 1000U);
  EXPECT_DOUBLE_EQ(*o.rate_hz, 30.0);
  EXPECT_EQ(o.repeat, 0U);
  EXPECT_EQ(o.lcm_url, "udpm://239.1.2.3:7000?ttl=1");
  EXPECT_EQ(o.seed, 42U);
  EXPECT_EQ(o.threads, Threads::kInline);
  EXPECT_EQ(o.name, "front");
  EXPECT_EQ(o.channel, "CLOUD_FRONT");
  EXPECT_EQ(o.given.size(), 25U);
}

TEST_F(CommandLine, HelpNamesEveryOptionInLinesThatFitATerminal) {
  Command c;
  EXPECT_EQ(c.run_sub({"encode", "--help"}), ExitCode::kDone);
  EXPECT_EQ(c.talk, "");
  for (const char* option :
       {"--camera", "--distortion", "--size",        "--units",    "--lidar",     "--range",
        "--noise",  "--tolerance",  "--off-surface", "--outliers", "--method",    "--regenerate",
        "--alpha",  "--smoothness", "--k",           "--effort",   "--budget-ms", "--slice-bytes",
        "--rate",   "--repeat",     "--lcm-url",     "--seed",     "--threads",   "--config",
        "--name",   "--channel"}) {
    EXPECT_NE(c.help.find(option), std::string::npos) << option;
  }
  std::istringstream lines(c.help);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 104U) << line;
}

TEST_F(CommandLine, ABadValueNamesTheOptionTheValueAndAnExample) {
  Command c;
  EXPECT_EQ(c.run_sub({"encode", "--tolerance", "ten"}), ExitCode::kUsage);
  EXPECT_TRUE(c.says("planecast encode: --tolerance: 'ten' is not a tolerance")) << c.talk;
  EXPECT_TRUE(c.says("10mm"));
  EXPECT_TRUE(c.says("See 'planecast encode --help'"));
  Command choice;
  EXPECT_EQ(choice.run({"--off-surface", "dropp"}), ExitCode::kUsage);
  EXPECT_TRUE(choice.says("--off-surface: 'dropp' is not one of: keep, drop; did you mean 'drop'?"))
      << choice.talk;
}

TEST_F(CommandLine, EveryOptionRefusesNonsense) {
  for (const char* option :
       {"--camera",     "--distortion",  "--size",     "--units",     "--range",       "--noise",
        "--tolerance",  "--off-surface", "--outliers", "--method",    "--regenerate",  "--alpha",
        "--smoothness", "--k",           "--effort",   "--budget-ms", "--slice-bytes", "--rate",
        "--repeat",     "--seed",        "--threads",  "--name",      "--channel",     "--lidar"}) {
    Command c;
    EXPECT_EQ(c.run({option, "not ok"}), ExitCode::kUsage) << option;
    EXPECT_TRUE(c.says(option)) << c.talk;
    EXPECT_TRUE(c.says("not ok")) << c.talk;
  }
}

TEST_F(CommandLine, AnUnknownOptionNamesTheNearest) {
  Command c;
  EXPECT_EQ(c.run({"--tolerence", "10mm", "in"}), ExitCode::kUsage);
  EXPECT_TRUE(c.says("unknown option '--tolerence'; did you mean '--tolerance'?")) << c.talk;
  Command with_value;
  EXPECT_EQ(with_value.run_sub({"encode", "in", "--ranges=1,2"}), ExitCode::kUsage);
  EXPECT_TRUE(with_value.says("unknown option '--ranges'; did you mean '--range'?"))
      << with_value.talk;
}

TEST_F(CommandLine, AnUnknownCommandNamesTheNearest) {
  Command c;
  EXPECT_EQ(c.run_sub({"encod", "in"}), ExitCode::kUsage);
  EXPECT_TRUE(c.says("unknown command 'encod'; did you mean 'encode'?")) << c.talk;
  Command none;
  EXPECT_EQ(none.run_sub({}), ExitCode::kUsage);
  EXPECT_TRUE(none.says("subcommand is required")) << none.talk;
}

TEST_F(CommandLine, AlphaIsInMetresOrHasAUnit) {
  Command metres;
  ASSERT_FALSE(metres.run({"--alpha", "0.05"})) << metres.talk;
  EXPECT_DOUBLE_EQ(metres.options.alpha_m, 0.05);
  Command unit;
  ASSERT_FALSE(unit.run({"--alpha", "20cm"})) << unit.talk;
  EXPECT_DOUBLE_EQ(unit.options.alpha_m, 0.2);
}

TEST_F(CommandLine, TheLastOfTwoFlagsCounts) {
  Command c;
  ASSERT_FALSE(c.run({"--tolerance", "10mm", "--tolerance", "5mm"}));
  EXPECT_EQ(to_string(c.options.tolerance), "5mm");
}

TEST_F(CommandLine, LcmDefaultUrlIsHonouredBelowOurOwnVariable) {
  set("LCM_DEFAULT_URL", "udpm://239.1.1.1:7001");
  Command c;
  ASSERT_FALSE(c.run({}));
  EXPECT_EQ(c.options.lcm_url, "udpm://239.1.1.1:7001");
  set("PLANECAST_LCM_URL", "memq://");
  Command own;
  ASSERT_FALSE(own.run({}));
  EXPECT_EQ(own.options.lcm_url, "memq://");
  Command flag;
  ASSERT_FALSE(flag.run({"--lcm-url", "udpm://239.2.2.2:1"}));
  EXPECT_EQ(flag.options.lcm_url, "udpm://239.2.2.2:1");
}

TEST_F(CommandLine, ABadVariableIsNamed) {
  set("PLANECAST_TOLERANCE", "much");
  Command c;
  EXPECT_EQ(c.run({}), ExitCode::kUsage);
  EXPECT_TRUE(c.says("environment variable PLANECAST_TOLERANCE")) << c.talk;
  EXPECT_TRUE(c.says("'much'"));
}

TEST_F(CommandLine, MethodPaperImpliesThePapersModeUnlessToldOtherwise) {
  Command c;
  ASSERT_FALSE(c.run({"--method", "paper"}));
  EXPECT_EQ(to_string(c.options.tolerance), "surfaces:3");
  EXPECT_EQ(c.options.off_surface, OffSurface::kDrop);
  EXPECT_EQ(c.options.outliers, Outliers::kDrop);
  EXPECT_EQ(c.options.regenerate, Regenerate::kRandom);
  Command told;
  ASSERT_FALSE(told.run({"--method", "paper", "--off-surface", "keep", "--outliers", "keep"}));
  EXPECT_EQ(told.options.off_surface, OffSurface::kKeep);
  EXPECT_EQ(told.options.outliers, Outliers::kKeep);
  Command bound;
  EXPECT_EQ(bound.run({"--method", "paper", "--tolerance", "10mm"}), ExitCode::kUsage);
  EXPECT_TRUE(bound.says("surfaces[:K]")) << bound.talk;
}

TEST_F(CommandLine, OptionsThatWouldDoNothingAreRefused) {
  Command drop;
  EXPECT_EQ(drop.run({"--off-surface", "drop", "--tolerance", "10mm"}), ExitCode::kUsage);
  EXPECT_TRUE(drop.says("--off-surface drop")) << drop.talk;
  Command lens;
  EXPECT_EQ(lens.run({"--distortion", "0.1,0,0,0"}), ExitCode::kUsage);
  EXPECT_TRUE(lens.says("--camera"));
  Command units;
  EXPECT_EQ(units.run({"--camera", "525,525,320,240,0.001", "--units", "0.01"}), ExitCode::kUsage);
  EXPECT_TRUE(units.says("--units")) << units.talk;
}

TEST_F(CommandLine, UnitsOverrideThePresets) {
  Command c;
  ASSERT_FALSE(c.run({"--camera", "kinect1", "--units", "0.0001"}));
  EXPECT_DOUBLE_EQ(intrinsics_of(c.options)->metres_per_unit, 0.0001);
  EXPECT_EQ(noise_or_preset(c.options)->kind, NoiseModel::Kind::kStereo);
  EXPECT_FALSE(noise_or_preset(CodecOptions{}).has_value());
  EXPECT_FALSE(intrinsics_of(CodecOptions{}).has_value());
}

TEST(ExitCodes, FollowTheStatus) {
  EXPECT_EQ(exit_code(Status::kOk), ExitCode::kDone);
  EXPECT_EQ(exit_code(Status::kWriteFailed), ExitCode::kFailed);
  EXPECT_EQ(exit_code(Status::kUsage), ExitCode::kUsage);
  EXPECT_EQ(exit_code(Status::kNotFound), ExitCode::kBadInput);
  EXPECT_EQ(exit_code(Status::kTruncated), ExitCode::kBadInput);
  EXPECT_EQ(exit_code(Status::kNetwork), ExitCode::kNetwork);
  EXPECT_EQ(exit_code(Status::kBoundExceeded), ExitCode::kBoundExceeded);
  EXPECT_EQ(to_int(ExitCode::kBoundExceeded), 5);
}

}  // namespace
}  // namespace planecast
