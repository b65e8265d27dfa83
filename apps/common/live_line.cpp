#include "apps/common/live_line.hpp"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <array>
#include <cstdint>

namespace planecast {

unsigned terminal_columns(std::FILE* stream) {
  const int descriptor = fileno(stream);
  if (descriptor < 0 || isatty(descriptor) == 0) return 0;
  winsize size{};
  if (ioctl(descriptor, TIOCGWINSZ, &size) != 0 || size.ws_col == 0) return 80;
  return size.ws_col;
}

std::string cut_to_columns(std::string_view text, unsigned columns) {
  std::size_t bytes = 0;
  for (unsigned column = 0; bytes < text.size(); ++column) {
    if (column == columns) break;
    do ++bytes;  // a lead byte and its continuation bytes 10xxxxxx
    while (bytes < text.size() && (static_cast<unsigned char>(text[bytes]) & 0xC0U) == 0x80U);
  }
  return std::string(text.substr(0, bytes));
}

LiveLine::LiveLine(std::FILE* stream, Style style, Clock::duration period)
    : stream_(stream),
      replace_(style == Style::kReplace && terminal_columns(stream) > 0),
      period_(period) {}

LiveLine::~LiveLine() {
  finish();
}

bool LiveLine::due(Clock::time_point now) const {
  return first_ || now - last_ >= period_;
}

void LiveLine::print(std::string_view line, Clock::time_point now) {
  // Keeping to the beat: a line that comes a little late does not make the next one later.
  last_ = first_ || now - last_ >= 2 * period_ ? now
          : now - last_ >= period_             ? last_ + period_
                                               : now;
  first_ = false;
  if (replace_) {
    const std::string shown = cut_to_columns(line, terminal_columns(stream_) - 1);
    std::fprintf(stream_, "\r\033[K%s", shown.c_str());
    open_ = true;
  } else {
    std::fprintf(stream_, "%.*s\n", static_cast<int>(line.size()), line.data());
  }
  std::fflush(stream_);
}

void LiveLine::finish() {
  if (!open_) return;
  std::fputc('\n', stream_);
  std::fflush(stream_);
  open_ = false;
}

std::string with_thousands(std::uint64_t number) {
  std::string text = std::to_string(number);
  for (std::size_t at = text.size(); at > 3;) text.insert(at -= 3, ",");
  return text;
}

std::string human_bytes(double bytes) {
  constexpr std::array kUnits = {"B", "kB", "MB", "GB", "TB"};
  std::size_t unit = 0;
  while (bytes >= 999.5 && unit + 1 < kUnits.size()) {
    bytes /= 1000.0;
    ++unit;
  }
  const int decimals = unit == 0 || bytes >= 99.95 ? 0 : bytes >= 9.995 ? 1 : 2;
  return fmt::format("{:.{}f} {}", bytes, decimals, kUnits[unit]);
}

}  // namespace planecast
