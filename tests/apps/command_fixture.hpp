// A command like ours, parsed in a test with an environment and files of its own.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "apps/common/command_line.hpp"

namespace planecast::test {

/// A command like ours: an input, an own option and flag, and the shared options; on its own
/// (planecastd) and as a subcommand (planecast encode).
struct Command {
  CodecOptions options;
  std::vector<std::string> input;
  std::string out;
  bool json = false;
  std::string talk;
  std::string help;

  void add_to(CLI::App& app) {
    app.add_option("input", input, "What to read");
    app.add_option("-o,--out", out, "Where to write");
    app.add_flag("--json", json, "Print JSON");
    add_codec_options(app, options);
  }

  std::optional<ExitCode> parse(CLI::App& app, std::vector<const char*> arguments) {
    arguments.insert(arguments.begin(), "program");
    std::ostringstream out_stream;
    std::ostringstream talk_stream;
    const auto code = parse_command_line(app, static_cast<int>(arguments.size()), arguments.data(),
                                         options, out_stream, talk_stream);
    help = out_stream.str();
    talk = talk_stream.str();
    return code;
  }

  /// Parses as planecastd.
  std::optional<ExitCode> run(const std::vector<const char*>& arguments) {
    CLI::App app("Streams", "planecastd");
    add_to(app);
    return parse(app, arguments);
  }

  /// Parses as planecast with two subcommands.
  std::optional<ExitCode> run_sub(const std::vector<const char*>& arguments) {
    CLI::App app("Codes", "planecast");
    app.require_subcommand(1);
    add_to(*app.add_subcommand("encode", "Packs"));
    app.add_subcommand("doctor", "Checks");
    return parse(app, arguments);
  }

  bool says(const std::string& part) const { return talk.find(part) != std::string::npos; }
};

/// Environment and files of one test, gone when it ends.
class CommandLine : public testing::Test {
 protected:
  void SetUp() override {
    for (const char* name : {"LCM_DEFAULT_URL", "PLANECAST_TOLERANCE", "PLANECAST_LCM_URL",
                             "PLANECAST_K", "PLANECAST_CONFIG", "PLANECAST_OFF_SURFACE"}) {
      if (const char* value = std::getenv(name)) before_[name] = value;
      unsetenv(name);
    }
  }
  void TearDown() override {
    for (const std::string& name : set_) unsetenv(name.c_str());
    for (const auto& [name, value] : before_) setenv(name.c_str(), value.c_str(), 1);
    for (const std::string& file : files_) std::filesystem::remove(file);
  }
  void set(const std::string& name, const std::string& value) {
    setenv(name.c_str(), value.c_str(), 1);
    set_.push_back(name);
  }
  std::string file(const std::string& text) {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    files_.push_back(testing::TempDir() + "planecast_" + test->name() + "_" +
                     std::to_string(getpid()) + ".toml");
    std::ofstream(files_.back()) << text;
    return files_.back();
  }

 private:
  std::map<std::string, std::string> before_;
  std::vector<std::string> set_;
  std::vector<std::string> files_;
};

}  // namespace planecast::test
