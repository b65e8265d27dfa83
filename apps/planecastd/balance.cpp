#include "apps/planecastd/balance.hpp"

#include <fmt/format.h>

#include "apps/common/live_line.hpp"

namespace planecast {
namespace {

void add_count(std::vector<std::string>& lines, const char* name, std::uint64_t count,
               const char* where) {
  if (count > 0) lines.push_back(fmt::format("    {:<20} {:>10}  {}", name, count, where));
}

void add_frames(std::vector<std::string>& lines, const StreamCounts& counts) {
  lines.push_back(fmt::format("  frames in              {:>10}", counts.in));
  lines.push_back(fmt::format("  frames out             {:>10}", counts.out()));
  lines.push_back(fmt::format("  frames failed          {:>10}", counts.failed()));
  add_count(lines, "source", counts.refused, "not fit for this stream");
  add_count(lines, "pipeline", counts.pipeline.failed, "could not be encoded");
  add_count(lines, "sender", counts.sender.did_not_fit, "larger than a frame buffer");
  add_count(lines, "network", counts.publisher.frames_failed, "a packet was refused or cut off");
  lines.push_back(fmt::format("  frames dropped         {:>10}", counts.dropped()));
  add_count(lines, "source", counts.passed_over, "a newer one came first");
  add_count(lines, "claim", counts.pipeline.dropped, "every frame slot was in use");
  add_count(lines, "publisher", counts.publisher.frames_dropped_oldest,
            "the oldest unsent, for a newer one");
  add_count(lines, "publisher at stop", counts.publisher.frames_dropped_at_stop, "still unsent");
  lines.push_back(fmt::format("  in = out + failed + dropped: {}",
                              counts.balanced() ? "holds" : "DOES NOT HOLD"));
}

void add_content(std::vector<std::string>& lines, const StreamCounts& counts) {
  const SenderTotals& sender = counts.sender;
  if (sender.sent == 0) return;
  const auto frames = static_cast<double>(sender.sent);
  const double raw = 12.0 * static_cast<double>(sender.readings);  // float x, y, z
  const auto packed = static_cast<double>(sender.bytes);
  lines.push_back(
      fmt::format("  a frame: {:.1f} surfaces, {} raw (12 bytes a point), {} packed ({:.1f} : 1), "
                  "{} key packets",
                  static_cast<double>(sender.surfaces) / frames, human_bytes(raw / frames),
                  human_bytes(packed / frames), raw / packed, sender.keys));
  add_count(lines, "frames", sender.less_effort, "coded with less effort, to keep --budget-ms");
  add_count(lines, "points", sender.out_of_range + counts.gated_readings,
            "out of --range, made holes");
  add_count(lines, "points", sender.outliers_dropped, "outliers, dropped as asked");
  add_count(lines, "points", sender.off_surface_dropped, "off the surfaces, dropped as asked");
}

void add_stages(std::vector<std::string>& lines, const StageRunner& runner) {
  lines.push_back("  stage          frames   failed   p50 ms   p99 ms   max ms  waiting at most");
  const auto ms = [](std::uint64_t ns) { return static_cast<double>(ns) * 1e-6; };
  for (std::uint32_t i = 0; i < runner.stage_count(); ++i) {
    const StageReport stage = runner.report(i);
    lines.push_back(fmt::format("  {:<10} {:>10} {:>8} {:>8.2f} {:>8.2f} {:>8.2f} {:>16}",
                                stage.name, stage.ok, stage.failed, ms(stage.latency.p50_ns),
                                ms(stage.latency.p99_ns), ms(stage.latency.max_ns),
                                stage.waiting_max));
  }
}

void add_watchdog(std::vector<std::string>& lines, const StageRunner& runner,
                  const Watchdog& watchdog) {
  std::string late, silent;
  for (std::uint32_t i = 0; i < runner.stage_count(); ++i) {
    const StageReport stage = runner.report(i);
    if (stage.late > 0) late += fmt::format(" {} {}", stage.name, stage.late);
    if (watchdog.silences(i) > 0) silent += fmt::format(" {} {}", stage.name, watchdog.silences(i));
  }
  lines.push_back(fmt::format("  watchdog, {:g} ms: late{}; silent{}",
                              static_cast<double>(watchdog.limit_ns()) * 1e-6,
                              late.empty() ? " 0" : late, silent.empty() ? " 0" : silent));
}

}  // namespace

bool StreamCounts::balanced() const {
  return in == refused + passed_over + pipeline.in && pipeline.in_flight() == 0 &&
         pipeline.ok == sender.sent + sender.did_not_fit && pipeline.failed == sender.failed &&
         sender.sent == publisher.frames_published && publisher.frames_queued == 0 &&
         in == out() + failed() + dropped();
}

std::vector<std::string> balance_lines(const StreamCounts& counts, const StageRunner& runner,
                                       const Watchdog* watchdog) {
  std::vector<std::string> lines;
  add_frames(lines, counts);
  add_content(lines, counts);
  add_stages(lines, runner);
  if (watchdog != nullptr) add_watchdog(lines, runner, *watchdog);
  return lines;
}

}  // namespace planecast
