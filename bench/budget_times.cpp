// What --budget-ms does: for each budget the CPU time that frames took, how many overran it by more
// than a tenth, the effort they got and the bits they cost:
//   budget_times INPUT... [codec options]
// Frames in the order of the input, three rounds, the first of which is not counted.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <vector>

#include "apps/common/command_line.hpp"
#include "apps/common/exit_codes.hpp"
#include "apps/common/frame_codec.hpp"
#include "apps/common/frame_source.hpp"
#include "apps/common/stream_setup.hpp"

namespace {

using namespace planecast;

constexpr double kBudgets[] = {0, 24, 16, 12, 8, 6, 4, 3, 2};
constexpr int kRounds = 3;

int fail(const Error& error) {
  fmt::print(stderr, "budget_times: {}\n", error.message);
  return to_int(ExitCode::kFailed);
}

Result<Done> time_budget(StreamSetup setup, const std::vector<SensorFrame>& frames,
                         double budget_ms) {
  setup.encoder.budget_ms = budget_ms;
  auto codec = FrameCodec::create(setup, kFileSliceBytes);
  if (!codec.ok()) return codec.error();
  std::vector<double> ms;
  std::array<int, kFrameEfforts> efforts{};
  double bits = 0, points = 0;
  for (int round = 0; round < kRounds; ++round) {
    for (const SensorFrame& frame : frames) {
      const double begin = thread_cpu_ms();
      const auto coded = codec->encode(setup, frame);
      if (!coded.ok()) return coded.error();
      const double took = thread_cpu_ms() - begin;
      if (round == 0) continue;
      ms.push_back(took);
      ++efforts[static_cast<std::size_t>(coded->effort)];
      bits += static_cast<double>(coded->report.bytes) * 8;
      points += coded->counts.input - coded->counts.out_of_range;
    }
  }
  std::sort(ms.begin(), ms.end());
  const auto over = std::count_if(ms.begin(), ms.end(),
                                  [&](double t) { return budget_ms > 0 && t > 1.1 * budget_ms; });
  fmt::print("{:>9} | {:8.2f} {:8.2f} {:8.2f} | {:6} |",
             budget_ms > 0 ? fmt::format("{}", budget_ms) : "none", ms[ms.size() / 2],
             ms[ms.size() * 95 / 100], ms.back(), over);
  for (const int n : efforts) fmt::print(" {:>10}", n);
  fmt::print(" | {:7.3f}\n", bits / points);
  return Done{};
}

int run(const std::vector<std::string>& inputs, const CodecOptions& options) {
  auto source = open_source(inputs, options);
  if (!source.ok()) return fail(source.error());
  std::vector<SensorFrame> frames;
  for (;;) {
    SensorFrame frame;
    const auto more = (*source)->next(frame);
    if (!more.ok()) return fail(more.error());
    if (!*more) break;
    frames.push_back(std::move(frame));
  }
  if (frames.empty()) return fail({Status::kUnreadable, "no frames"});
  const auto setup = setup_stream(options, (*source)->sensor(), frames.front());
  if (!setup.ok()) return fail(setup.error());
  fmt::print("{:>9} | {:>8} {:>8} {:>8} | {:>6} | {:>10} {:>10} {:>10} {:>10} | bit/point\n",
             "budget ms", "p50 ms", "p95 ms", "max ms", "> 110%", "full", "planes", "neighbours",
             "runs");
  for (const double budget : kBudgets) {
    if (const auto done = time_budget(*setup, frames, budget); !done.ok())
      return fail(done.error());
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"CPU time of frames under a time budget, and what it costs."};
  CodecOptions options;
  std::vector<std::string> inputs;
  app.add_option("inputs", inputs, "files, folders or sim:room[:FRAMES]");
  add_codec_options(app, options);
  if (const auto code = parse_command_line(app, argc, argv, options)) return to_int(*code);
  return run(inputs, options);
}
