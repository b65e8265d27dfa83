// planecast eval: what coding an input costs in bytes, error and time, frame by frame.
#include <fmt/core.h>

#include <algorithm>
#include <cstdio>
#include <future>
#include <thread>

#include "apps/common/json_report.hpp"
#include "apps/common/live_line.hpp"
#include "apps/planecast/commands.hpp"
#include "apps/planecast/describe.hpp"
#include "apps/planecast/eval_frame.hpp"
#include "apps/planecast/eval_table.hpp"

namespace planecast {
namespace {

// A run: frames are coded and timed one after the other with nothing beside them; the distances of
// a batch are then measured side by side, since they take longest and need no codec.
class EvalRun {
 public:
  EvalRun(FrameReader& reader, const CodecOptions& options, bool as_json)
      : reader_(reader),
        evaluator_(options, reader.sensor()),
        json_(as_json),
        show_(terminal_columns(stderr) > 0),
        line_(stderr, LiveLine::Style::kReplace) {}

  Result<Done> run() {
    for (bool more = true; more;) {
      const auto batch = code_batch(more);
      if (!batch.ok()) return batch.error();
      measure(*batch);
    }
    line_.finish();
    return Done{};
  }

  const Json& frames() const { return frames_; }
  const StreamSetup& setup() const { return evaluator_.setup(); }
  bool broken() const { return broken_; }

 private:
  Result<std::vector<EvaluatedFrame>> code_batch(bool& more) {
    const std::size_t most = std::max(1U, std::thread::hardware_concurrency());
    std::vector<EvaluatedFrame> batch;
    while (batch.size() < most) {
      SensorFrame frame;
      const auto got = reader_.next(frame);
      if (!got.ok()) return got.error();
      more = *got;
      if (!more) break;
      auto evaluated = evaluator_.evaluate(frame);
      if (!evaluated.ok()) return evaluated.error();
      report_broken(*evaluated);
      batch.push_back(std::move(*evaluated));
    }
    return batch;
  }

  void measure(const std::vector<EvaluatedFrame>& batch) {
    std::vector<std::future<Json>> figures;
    for (const EvaluatedFrame& frame : batch)
      figures.push_back(std::async(std::launch::async, [&frame] { return figures_of(frame); }));
    for (auto& done : figures) {
      frames_.push_back(done.get());
      print_row(frames_.back());
    }
  }

  void print_row(const Json& figures) {
    if (!json_) {
      line_.finish();
      if (frames_.size() == 1) fmt::print("{}\n", table_head());
      fmt::print("{}\n", table_row(figures["name"].get<std::string>(), figures));
      std::fflush(stdout);
    } else if (show_ && line_.due()) {
      line_.print(fmt::format("{} of {} frames", frames_.size(), reader_.count()));
    }
  }

  void report_broken(const EvaluatedFrame& frame) {
    for (const std::string& what : {frame.verdict.broken, frame.wire_broken}) {
      if (what.empty()) continue;
      broken_ = true;
      tell({frame.name + ": the bound does not hold: " + what});
    }
  }

  FrameReader& reader_;
  FrameEvaluator evaluator_;
  bool json_;
  bool show_;
  LiveLine line_;
  bool broken_ = false;
  Json frames_ = Json::array();
};

}  // namespace

ExitCode run_eval(const CommandArguments& arguments, const CodecOptions& options) {
  auto reader = FrameReader::open(arguments.inputs, options);
  if (!reader.ok()) return complain(reader.error());
  EvalRun run(*reader, options, arguments.json);
  if (const auto done = run.run(); !done.ok()) return complain(done.error());
  Json report = report_of(run.frames());
  if (arguments.json) {
    report["tolerance"] = to_string(options.tolerance);
    report["bound_held"] = !run.broken();
    report["sensor"] = describe(run.setup().encoder.stream);
    report["notes"] = run.setup().notes;
    fmt::print("{}\n", report.dump(2));
  } else if (report["frames"].size() > 1) {
    fmt::print("{}\n", table_row("mean", report["mean"]));
  }
  return run.broken() ? ExitCode::kBoundExceeded : ExitCode::kDone;
}

}  // namespace planecast
