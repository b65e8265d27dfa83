#include "apps/recv/receive_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "apps/common/live_line.hpp"

namespace planecast {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

double ms(std::uint64_t ns) {
  return static_cast<double>(ns) * 1e-6;
}

/// "8.1 ms", or what stands for "not known".
std::string latency_text(const StreamSecond& second) {
  if (second.frames == 0) return "-";
  if (second.latencies_ns.empty()) return "no shared clock";
  return fmt::format("{:.1f} ms", second.latency_p50_ms());
}

std::string ratio_text(double ratio) {
  return ratio >= 1e6 ? "over" : fmt::format("{:.3f}", ratio);
}

std::string latency_line(const char* name, const LatencySummary& s) {
  return fmt::format("  {:<9} p50 {:.2f} ms  p90 {:.2f}  p99 {:.2f}  max {:.2f}", name,
                     ms(s.p50_ns), ms(s.p90_ns), ms(s.p99_ns), ms(s.max_ns));
}

std::string check_line(const StreamTotals& t) {
  std::string line = fmt::format(
      "  checked   {} frames  max error {:.3f} mm  error/bound {}  missing {}  invented {}",
      t.checked, t.max_error_m * 1e3, ratio_text(t.max_ratio), t.missing, t.invented);
  if (t.dropped > 0) line += fmt::format("  dropped as asked {}", with_thousands(t.dropped));
  if (t.incomparable > 0)
    line += fmt::format("  NOT COMPARABLE {} (other size, unit or kind than the reference)",
                        t.incomparable);
  return line;
}

}  // namespace

std::string live_line(const ReceiveTotals& totals, double seconds,
                      const ReceiverStatistics& statistics, bool more) {
  if (totals.streams().empty()) return "waiting for frames";
  std::string line;
  for (const auto& [stream, total] : totals.streams()) {
    const StreamSecond& second = totals.second(stream);
    const StreamStatistics s = stream_statistics(statistics, stream);
    if (!line.empty()) line += "  |  ";
    if (totals.streams().size() > 1) line += fmt::format("stream {}: ", stream);
    line += fmt::format("frame {:>6}  {:4.1f} Hz  {:>2} surfaces  {:>7} points  {:>8}  {}",
                        total.last.frame, static_cast<double>(second.frames) / seconds,
                        total.last.surfaces, with_thousands(total.last.points),
                        human_bytes(static_cast<double>(second.bytes) /
                                    static_cast<double>(std::max<std::uint64_t>(second.frames, 1))),
                        latency_text(second));
    if (total.checked > 0 && second.frames > 0)
      line += fmt::format("  error/bound {}", ratio_text(second.max_ratio));
    line += fmt::format("  lost {}  partial {}", s.frames_lost, total.partial);
    if (total.no_key + total.joining > 0)
      line += fmt::format("  without key {}", total.no_key + total.joining);
    if (more) {
      line += fmt::format("  slices {} dup {}  unknown key {}  key age {:.2f} s", s.slices_received,
                          s.slices_duplicate, s.unknown_keys,
                          static_cast<double>(total.last.key_age_ns) * 1e-9);
    }
  }
  return line;
}

std::vector<std::string> status_lines(const ReceiveTotals& totals, double at_s, double seconds,
                                      const ReceiverStatistics& statistics) {
  std::vector<std::string> lines;
  for (const auto& [stream, total] : totals.streams()) {
    const StreamSecond& second = totals.second(stream);
    const StreamStatistics s = stream_statistics(statistics, stream);
    lines.push_back(fmt::format(
        "t={:.3f} stream={} frame={} frames={} hz={:.2f} surfaces={} points={} bytes={} "
        "latency_p50_ms={:.3f} max_error_mm={:.4f} max_error_ratio={:.4f} lost={} partial={}",
        at_s, stream, total.last.frame, total.frames(),
        static_cast<double>(second.frames) / seconds, total.last.surfaces, total.last.points,
        second.bytes, second.latency_p50_ms(), total.max_error_m * 1e3,
        total.checked > 0 && second.frames > 0 ? second.max_ratio : kNone, s.frames_lost,
        total.partial));
  }
  return lines;
}

std::vector<std::string> final_lines(const ReceiveTotals& totals,
                                     const ReceiverStatistics& statistics) {
  std::vector<std::string> lines;
  for (const auto& [stream, t] : totals.streams()) {
    const StreamStatistics s = stream_statistics(statistics, stream);
    const LatencySummary latency = t.latency.summary();
    const bool known = latency.count > 0;
    lines.push_back(fmt::format(
        "final=1 stream={} complete={} partial={} lost={} no_key={} joining={} refused={} "
        "skipped={} senders={} sink_dropped={} slices={} slices_refused={} slices_lost={} "
        "duplicates={} points={} surfaces={} bytes={} messages={} wire_bytes={} "
        "latency_p50_ms={:.3f} latency_p90_ms={:.3f} latency_p99_ms={:.3f} latency_max_ms={:.3f} "
        "decode_p50_ms={:.3f} checked={} incomparable={} missing={} dropped={} invented={} "
        "max_error_mm={:.4f} max_error_ratio={:.4f}",
        stream, t.complete, t.partial, s.frames_lost, t.no_key, t.joining, t.refused,
        s.frames_skipped, t.senders, t.sink_dropped, t.slices, t.slices_refused, s.slices_lost,
        s.slices_duplicate, t.points, t.surfaces, t.bytes, statistics.link.messages,
        statistics.link.bytes, known ? ms(latency.p50_ns) : kNone,
        known ? ms(latency.p90_ns) : kNone, known ? ms(latency.p99_ns) : kNone,
        known ? ms(latency.max_ns) : kNone, ms(t.decode.percentile_ns(50)), t.checked,
        t.incomparable, t.missing, t.dropped, t.invented, t.max_error_m * 1e3,
        t.checked > 0 ? t.max_ratio : kNone));
  }
  return lines;
}

std::vector<std::string> table(const ReceiveTotals& totals, const ReceiverStatistics& statistics,
                               bool more) {
  std::vector<std::string> lines;
  for (const auto& [stream, t] : totals.streams()) {
    const StreamStatistics s = stream_statistics(statistics, stream);
    lines.push_back(fmt::format("stream {}", stream));
    lines.push_back(fmt::format(
        "  frames    {} handed on = {} complete + {} partial + {} before a key packet + {} without "
        "their key + {} refused + {} replaced by newer; {} lost",
        s.frames_complete + s.frames_partial, t.complete, t.partial, t.joining, t.no_key, t.refused,
        s.frames_skipped, s.frames_lost));
    lines.push_back(fmt::format("  points    {}  in {} of slices", with_thousands(t.points),
                                human_bytes(static_cast<double>(t.bytes))));
    if (t.latency.count() > 0) lines.push_back(latency_line("latency", t.latency.summary()));
    if (more) lines.push_back(latency_line("decode", t.decode.summary()));
    if (t.senders > 1) lines.push_back(fmt::format("  senders   {} in turn", t.senders));
    if (t.sink_dropped > 0)
      lines.push_back(
          fmt::format("  output    {} frames dropped: the sinks were busy", t.sink_dropped));
    if (t.checked > 0) lines.push_back(check_line(t));
  }
  if (!more) return lines;
  for (std::string& line : to_lines(statistics)) lines.push_back(std::move(line));
  return lines;
}

}  // namespace planecast
