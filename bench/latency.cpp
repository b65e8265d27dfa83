// Sensor to cloud: how long a frame takes from memory to a readable cloud, step by step, with
// p50, p90, p99, p99.9 and max, in process and over LCM on loopback, idle and beside a busy core;
// and in the same run how late this machine wakes a thread at all.
//   latency INPUT... [--rates 30,60,90] [--paths inprocess,lcm] [--load none,core] [--frames N]
//           [--json FILE] [--svg FILE] [codec options]
// LCM in a network of its own: tests/support/netns.sh build/bench/bench/latency ...
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <fstream>
#include <nlohmann/json.hpp>

#include "apps/common/command_line.hpp"
#include "apps/common/exit_codes.hpp"
#include "apps/common/points_setup.hpp"
#include "bench/latency_run.hpp"
#include "bench/latency_svg.hpp"

namespace {

using namespace planecast;
using namespace planecast::bench;

struct Wishes {
  std::vector<std::string> inputs;
  std::vector<double> rates = {30, 60, 90};
  std::vector<std::string> paths = {"inprocess", "lcm"};
  std::vector<std::string> loads = {"none", "core"};
  std::uint32_t frames = 300;
  std::size_t preload = 60;
  std::string json_file, svg_file;
};

int fail(const Error& error) {
  fmt::print(stderr, "latency: {}\n", error.message);
  return to_int(exit_code(error.status));
}

Result<StreamSetup> load(const Wishes& wishes, const CodecOptions& options, Frames& frames) {
  auto source = open_source(wishes.inputs, options);
  if (!source.ok()) return source.error();
  SensorFrame frame;
  auto more = (*source)->next(frame);
  if (!more.ok()) return more.error();
  auto setup = setup_stream(options, (*source)->sensor(), frame);
  if (!setup.ok()) return setup;
  for (; more.ok() && *more && frames.count() < wishes.preload; more = (*source)->next(frame)) {
    if (setup->encoder.stream.kind == FrameKind::kDepth) {
      if (const auto done = to_depth(*setup, frame, frames.depth.emplace_back()); !done.ok())
        return done.error();
    } else if (setup->encoder.stream.kind == FrameKind::kPoints) {
      if (const auto done = to_points(*setup, frame, frames.points.emplace_back()); !done.ok())
        return done.error();
    } else {
      if (const auto done = to_raw_points(*setup, frame, frames.points.emplace_back()); !done.ok())
        return done.error();
    }
  }
  if (!more.ok()) return more.error();
  return setup;
}

double ms(std::int64_t ns) {
  return static_cast<double>(ns) * 1e-6;
}

void print_step(const Step& step) {
  fmt::print("  {:<16} {:8.3f} {:8.3f} {:8.3f} {:8.3f} {:8.3f}\n", step.name, ms(step.at(50)),
             ms(step.at(90)), ms(step.at(99)), ms(step.at(99.9)), ms(step.at(100)));
}

void print(const LatencyResult& result) {
  fmt::print(
      "{:g} Hz, {}, {}: {} of {} frames readable; no slot {}, not sent {}, skipped {}, "
      "lost {}\n",
      result.plan.rate_hz, result.plan.lcm ? "LCM loopback" : "in process",
      result.plan.loaded ? "one core busy" : "idle", result.readable, result.offered,
      result.no_slot, result.not_sent, result.skipped, result.lost);
  fmt::print("  {:<16} {:>8} {:>8} {:>8} {:>8} {:>8}  ms\n", "step", "p50", "p90", "p99", "p99.9",
             "max");
  for (const Step& step : result.steps) print_step(step);
  print_step(result.timer);
}

nlohmann::json to_json(const Step& step) {
  return {{"name", step.name},         {"count", step.ns.size()},   {"p50_ms", ms(step.at(50))},
          {"p90_ms", ms(step.at(90))}, {"p99_ms", ms(step.at(99))}, {"p99_9_ms", ms(step.at(99.9))},
          {"max_ms", ms(step.at(100))}};
}

nlohmann::json to_json(const LatencyResult& result) {
  nlohmann::json steps = nlohmann::json::array();
  for (const Step& step : result.steps) steps.push_back(to_json(step));
  return {{"rate_hz", result.plan.rate_hz},
          {"path", result.plan.lcm ? "lcm" : "inprocess"},
          {"loaded", result.plan.loaded},
          {"offered", result.offered},
          {"readable", result.readable},
          {"no_slot", result.no_slot},
          {"not_sent", result.not_sent},
          {"skipped", result.skipped},
          {"lost", result.lost},
          {"steps", steps},
          {"timer", to_json(result.timer)}};
}

int run(const Wishes& wishes, const CodecOptions& options) {
  Frames frames;
  auto setup = load(wishes, options, frames);
  if (!setup.ok()) return fail(setup.error());
  setup->encoder.stages.slice_bytes = options.slice_bytes - 10;
  std::vector<LatencyResult> results;
  for (const std::string& path : wishes.paths) {
    for (const std::string& load : wishes.loads) {
      for (const double rate : wishes.rates) {
        auto result = run_latency({.rate_hz = rate,
                                   .lcm = path == "lcm",
                                   .loaded = load == "core",
                                   .frames = wishes.frames},
                                  *setup, options, frames);
        if (!result.ok()) return fail(result.error());
        print(*result);
        results.push_back(std::move(*result));
      }
    }
  }
  nlohmann::json all = nlohmann::json::array();
  for (const LatencyResult& result : results) all.push_back(to_json(result));
  if (!wishes.json_file.empty()) std::ofstream(wishes.json_file) << all.dump(1) << '\n';
  if (!wishes.svg_file.empty()) std::ofstream(wishes.svg_file) << latency_svg(results);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Time of each frame from memory to readable cloud."};
  CodecOptions options;
  Wishes wishes;
  app.add_option("inputs", wishes.inputs, "files, folders or sim:room[:FRAMES]");
  app.add_option("--rates", wishes.rates, "frames a second")->delimiter(',');
  app.add_option("--paths", wishes.paths, "inprocess, lcm")
      ->delimiter(',')
      ->check(CLI::IsMember({"inprocess", "lcm"}));
  app.add_option("--load", wishes.loads, "none, core: another thread keeps one core busy")
      ->delimiter(',')
      ->check(CLI::IsMember({"none", "core"}));
  app.add_option("--frames", wishes.frames, "frames a run")->check(CLI::Range(1, 1000000));
  app.add_option("--preload", wishes.preload, "different frames kept in memory");
  app.add_option("--json", wishes.json_file, "every figure");
  app.add_option("--svg", wishes.svg_file, "curves of the whole time");
  add_codec_options(app, options);
  if (const auto code = parse_command_line(app, argc, argv, options)) return to_int(*code);
  return run(wishes, options);
}
