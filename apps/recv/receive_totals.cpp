#include "apps/recv/receive_totals.hpp"

#include <algorithm>
#include <limits>

namespace planecast {
namespace {

void add_check(StreamTotals& total, const FrameRecord& record) {
  ++total.checked;
  total.incomparable += !record.comparable;
  total.missing += record.missing;
  total.dropped += record.dropped;
  total.invented += record.invented;
  total.max_error_m = std::max(total.max_error_m, record.max_error_m);
  total.max_ratio = std::max(total.max_ratio, record.max_ratio);
}

void add_end(StreamTotals& total, const FrameRecord& record) {
  switch (record.end) {
    case FrameEnd::kComplete:
      ++total.complete;
      break;
    case FrameEnd::kPartial:
      ++total.partial;
      break;
    case FrameEnd::kNoKey:
      ++(total.frames() == 0 ? total.joining : total.no_key);
      break;
    case FrameEnd::kRefused:
      ++total.refused;
      break;
  }
}

}  // namespace

StreamStatistics stream_statistics(const ReceiverStatistics& statistics, std::uint16_t stream) {
  for (std::uint16_t i = 0; i < statistics.stream_count; ++i) {
    if (statistics.streams[i].stream == stream) return statistics.streams[i];
  }
  return {};
}

double StreamSecond::latency_p50_ms() const {
  if (latencies_ns.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::vector<std::int64_t> sorted = latencies_ns;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  return static_cast<double>(*middle) * 1e-6;
}

void ReceiveTotals::add(const FrameRecord& record) {
  ++records_;
  StreamTotals& total = totals_[record.stream];
  StreamSecond& second = second_[record.stream];
  if (total.senders == 0 || total.session != record.session) ++total.senders;
  total.session = record.session;
  add_end(total, record);
  total.slices += record.slices;
  total.slices_refused += record.slices_refused;
  total.bytes += record.bytes;
  second.bytes += record.bytes;
  if (record.end == FrameEnd::kNoKey || record.end == FrameEnd::kRefused) return;
  total.last = record;
  total.points += record.points;
  total.surfaces += record.surfaces;
  total.sink_dropped += record.sink_dropped;
  total.decode.record(static_cast<std::uint64_t>(record.decode_ns));
  ++second.frames;
  if (record.latency_ns >= 0) {
    total.latency.record(static_cast<std::uint64_t>(record.latency_ns));
    second.latencies_ns.push_back(record.latency_ns);
  }
  if (record.checked) {
    add_check(total, record);
    second.max_ratio = std::max(second.max_ratio, record.max_ratio);
  }
}

void ReceiveTotals::next_second() {
  for (auto& [stream, second] : second_) {
    second.frames = second.bytes = 0;
    second.latencies_ns.clear();
    second.max_ratio = 0;
  }
}

bool ReceiveTotals::bound_exceeded() const {
  return std::any_of(totals_.begin(), totals_.end(), [](const auto& entry) {
    const StreamTotals& t = entry.second;
    return t.max_ratio > 1.0 || t.missing > 0 || t.invented > 0;
  });
}

bool ReceiveTotals::frame_missing(const ReceiverStatistics& statistics) const {
  std::uint64_t complete = 0, bad = 0;
  for (const auto& [stream, t] : totals_) {
    const StreamStatistics s = stream_statistics(statistics, stream);
    complete += t.complete;
    bad += t.partial + t.refused + t.no_key + t.incomparable + s.frames_lost + s.frames_skipped +
           s.frames_discarded;
  }
  return complete == 0 || bad > 0;
}

}  // namespace planecast
