#include "apps/planecastd/status_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace planecast {
namespace {

constexpr double kRawPointBytes = 12;  // float x, y, z

double mean(std::uint64_t before, std::uint64_t now, std::uint64_t frames) {
  return frames == 0 ? 0 : static_cast<double>(now - before) / static_cast<double>(frames);
}

}  // namespace

StreamRates rates_between(const StreamMoment& before, const StreamMoment& now,
                          std::int64_t encode_median_ns) {
  const double seconds =
      static_cast<double>(std::max<std::int64_t>(now.time_ns - before.time_ns, 1)) * 1e-9;
  StreamRates out;
  out.frame = now.sender.last_frame;
  out.frames = now.sender.sent - before.sender.sent;
  out.hz = static_cast<double>(out.frames) / seconds;
  out.surfaces = mean(before.sender.surfaces, now.sender.surfaces, out.frames);
  out.raw_bytes = kRawPointBytes * mean(before.sender.readings, now.sender.readings, out.frames);
  out.packed_bytes = mean(before.sender.bytes, now.sender.bytes, out.frames);
  out.mbit_s = static_cast<double>(now.sender.bytes - before.sender.bytes) * 8e-6 / seconds;
  out.encode_ms = static_cast<double>(encode_median_ns) * 1e-6;
  out.dropped = now.dropped;
  out.failed = now.failed;
  return out;
}

std::string to_live_line(const StreamRates& rates) {
  return fmt::format(
      "frame {}  {:.1f} Hz  {:.0f} surfaces  raw {}  packed {}  {:.2f} Mbit/s  encode {:.1f} ms  "
      "dropped {}{}",
      rates.frame, rates.hz, rates.surfaces, human_bytes(rates.raw_bytes),
      human_bytes(rates.packed_bytes), rates.mbit_s, rates.encode_ms, rates.dropped,
      rates.failed > 0 ? fmt::format("  failed {}", rates.failed) : "");
}

std::string to_status_line(const StreamRates& rates) {
  return fmt::format(
      "frame={} hz={:.2f} surfaces={:.1f} raw_bytes={:.0f} packed_bytes={:.0f} mbit_s={:.3f} "
      "encode_ms={:.3f} dropped={} failed={}",
      rates.frame, rates.hz, rates.surfaces, rates.raw_bytes, rates.packed_bytes, rates.mbit_s,
      rates.encode_ms, rates.dropped, rates.failed);
}

Result<StatusReport> StatusReport::open(std::FILE* talk, const std::string& file) {
  StatusReport report;
  report.live_ = std::make_unique<LiveLine>(talk);
  if (file.empty()) return report;
  report.file_.reset(std::fopen(file.c_str(), "a"));
  if (report.file_ == nullptr)
    return Error{Status::kWriteFailed, fmt::format("{}: {}; --status needs a file it can append to",
                                                   file, std::strerror(errno))};
  return report;
}

void StatusReport::print(const StreamRates& rates) {
  live_->print(to_live_line(rates));
  if (file_ == nullptr) return;
  fmt::print(file_.get(), "{}\n", to_status_line(rates));
  std::fflush(file_.get());
}

}  // namespace planecast
