// Bits against error and time: one frame through our codec and every packaged peer, in one run.
//   rate_distortion NAME INPUT [codec options] [--targets MM,...] >> rows.csv
// CSV on standard output, one row a codec and setting; bench/rate_distortion.sh runs the set of
// frames and bench/rate_distortion_report.py makes tables and curves of the rows.
#include <fmt/core.h>

#include <CLI/CLI.hpp>

#include "apps/common/command_line.hpp"
#include "bench/rd_run.hpp"
#include "core/metrics/compression.hpp"

namespace {

using namespace planecast;
using namespace planecast::bench;

constexpr const char* kHeader =
    "frame,points,codec,setting,ours,target_d1_mm,bits_per_point,bytes,points_out,dropped,merged,"
    "d1_ab_mm,d1_ba_mm,d1_mm,d2_mm,max_mm,encode_ms,decode_ms\n";

void print_row(const std::string& name, std::size_t points, const RdRow& r) {
  const RdDistance& d = r.distance;
  const std::size_t dropped = points - std::min(points, d.points_out);
  fmt::print(
      "{},{},{},{},{},{},{:.4f},{},{},{},{},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},{:.3f},{:.3f}\n",
      name, points, r.codec, r.setting, r.ours ? 1 : 0,
      r.target_d1_mm ? fmt::format("{}", *r.target_d1_mm) : "", bits_per_point(r.bytes, points),
      r.bytes, d.points_out, dropped, d.merged, d.d1_ab_m * 1e3, d.d1_ba_m * 1e3, d.d1_m * 1e3,
      d.d2_m * 1e3, d.max_m * 1e3, r.encode_ms, r.decode_ms);
}

struct Arguments {
  std::string name;
  std::vector<std::string> inputs;
  std::vector<double> targets_mm;
  std::vector<std::string> efforts{"fast"};
  std::string only;
  bool header = false;
};

int run(const Arguments& arguments, CodecOptions options) {
  auto source = open_source(arguments.inputs, options);
  if (!source.ok()) throw std::runtime_error(source.error().message);
  SensorFrame first;
  const auto more = (*source)->next(first);
  if (!more.ok()) throw std::runtime_error(more.error().message);
  const RdFrame frame = prepare_frame(options, (*source)->sensor(), std::move(first));
  if (arguments.header) fmt::print("{}", kHeader);
  for (const std::string& effort : arguments.efforts) {
    options.effort = effort == "best" ? Effort::kBest : Effort::kFast;
    options.given.insert("effort");
    for (const RdRow& row : own_rows(options, frame, arguments.targets_mm))
      print_row(arguments.name, frame.points.size(), row);
  }
  std::vector<std::string> skipped;
  for (const RdRow& row : peer_rows(frame, arguments.only, skipped))
    print_row(arguments.name, frame.points.size(), row);
  for (const std::string& peer : skipped)
    fmt::print(stderr, "skipped: {}; toolchains/setup.sh --bench installs it\n", peer);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Bits against error and time of one frame, ours and every packaged peer's."};
  CodecOptions options;
  Arguments arguments;
  app.add_option("name", arguments.name, "of the frame, in the first column");
  app.add_option("inputs", arguments.inputs, "a file, or sim:room; the first frame counts");
  app.add_option("--targets", arguments.targets_mm, "d1 [mm] to find our bounds for")
      ->delimiter(',');
  app.add_option("--efforts", arguments.efforts, "fast,best")->delimiter(',');
  app.add_flag("--header", arguments.header, "start with the names of the columns");
  app.add_option("--only", arguments.only,
                 "peers with this in their name; \"none\": our rows only");
  add_codec_options(app, options);
  if (const auto code = parse_command_line(app, argc, argv, options)) return to_int(*code);
  try {
    return run(arguments, options);
  } catch (const std::exception& error) {
    fmt::print(stderr, "rate_distortion: {}\n", error.what());
    return to_int(ExitCode::kFailed);
  }
}
