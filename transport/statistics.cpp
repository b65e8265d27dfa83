#include "transport/statistics.hpp"

#include <cstdio>
#include <string_view>

namespace planecast {
namespace {

struct Field {
  std::string_view name;
  std::uint64_t value;
  bool always;
};

template <std::size_t N>
void append_fields(std::string& line, const Field (&fields)[N]) {
  for (const Field& field : fields) {
    if (!field.always && field.value == 0) continue;
    line.append("  ").append(field.name).append(" ").append(std::to_string(field.value));
  }
}

std::string milliseconds(std::int64_t ns) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f", static_cast<double>(ns) * 1e-6);
  return text;
}

std::string histogram_line(std::string_view name, const TransitHistogram& histogram) {
  std::string line = "  ";
  line.append(name).append(" ms  p50 ").append(milliseconds(histogram.quantile_ns(0.5)));
  line.append("  p99 ").append(milliseconds(histogram.quantile_ns(0.99)));
  return line.append("  max ").append(milliseconds(histogram.max_ns()));
}

void append_stream(std::vector<std::string>& lines, const StreamStatistics& s) {
  std::string frames = "stream " + std::to_string(s.stream) + "  frames:";
  append_fields(frames, {{"complete", s.frames_complete, true},
                         {"partial", s.frames_partial, true},
                         {"lost", s.frames_lost, true},
                         {"skipped", s.frames_skipped, true},
                         {"taken", s.frames_taken, true},
                         {"discarded", s.frames_discarded, false},
                         {"session changes", s.session_changes, false},
                         {"resyncs", s.resyncs, false}});
  lines.push_back(std::move(frames));
  std::string slices = "  slices:";
  append_fields(slices, {{"received", s.slices_received, true},
                         {"lost", s.slices_lost, true},
                         {"duplicate", s.slices_duplicate, false},
                         {"late", s.slices_late, false},
                         {"reordered", s.slices_reordered, false},
                         {"old session", s.slices_old_session, false},
                         {"inconsistent", s.slices_inconsistent, false},
                         {"too large", s.slices_too_large, false},
                         {"no slot", s.slices_no_slot, false},
                         {"discarded", s.slices_discarded, false},
                         {"unknown key", s.unknown_keys, false},
                         {"keys", s.keys_received, true},
                         {"keys ignored", s.keys_ignored, false}});
  lines.push_back(std::move(slices));
  lines.push_back(histogram_line("assembly", s.assembly) + "  jitter " +
                  milliseconds(static_cast<std::int64_t>(s.jitter_ns)));
  if (s.capture.count() > 0) lines.push_back(histogram_line("capture to frame", s.capture));
}

}  // namespace

void LinkStatistics::count_refused(Status status) noexcept {
  switch (status) {
    case Status::kTruncated:
    case Status::kTrailingBytes:
      ++bad_length;
      break;
    case Status::kBadMagic:
      ++bad_type;
      break;
    case Status::kUnsupportedVersion:
      ++bad_version;
      break;
    case Status::kBadCheck:
      ++bad_check;
      break;
    default:
      ++bad_packet;
      break;
  }
}

std::vector<std::string> to_lines(const ReceiverStatistics& statistics) {
  std::vector<std::string> lines;
  std::string line = "messages:";
  const LinkStatistics& link = statistics.link;
  append_fields(line, {{"received", link.messages, true},
                       {"bytes", link.bytes, true},
                       {"bad length", link.bad_length, false},
                       {"other type", link.bad_type, false},
                       {"unknown version", link.bad_version, false},
                       {"bad check", link.bad_check, false},
                       {"malformed", link.bad_packet, false},
                       {"too many streams", link.unknown_stream, false},
                       {"receive errors", link.receive_errors, false}});
  lines.push_back(std::move(line));
  for (std::uint16_t i = 0; i < statistics.stream_count; ++i)
    append_stream(lines, statistics.streams[i]);
  return lines;
}

}  // namespace planecast
