// One line of status a second, for people: on a terminal it replaces itself, in a log it is a line.
#pragma once

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <string>
#include <string_view>

namespace planecast {

/// Prints to a stream that the caller keeps open (standard error, as a rule). One thread.
class LiveLine {
 public:
  using Clock = std::chrono::steady_clock;

  enum class Style {
    kReplace,  ///< on a terminal each line takes the place of the last one
    kScroll,   ///< every line stays
  };

  explicit LiveLine(std::FILE* stream, Style style = Style::kScroll,
                    Clock::duration period = std::chrono::seconds(1));
  /// As finish().
  ~LiveLine();
  LiveLine(const LiveLine&) = delete;
  LiveLine& operator=(const LiveLine&) = delete;

  /// Whether a period has passed since the last line (true at first). Ask before composing one.
  bool due(Clock::time_point now = Clock::now()) const;

  /// Prints the line, due or not, cut to the terminal's width where it replaces another.
  void print(std::string_view line, Clock::time_point now = Clock::now());

  /// Ends a line that could still be replaced, so that other output starts on its own line.
  void finish();

 private:
  std::FILE* stream_;
  bool replace_;
  bool open_ = false;  // a replaceable line stands on the terminal
  bool first_ = true;
  Clock::duration period_;
  Clock::time_point last_{};
};

/// Columns of the terminal behind a stream; 0 when it is none.
unsigned terminal_columns(std::FILE* stream);

/// The first `columns` characters of UTF-8 text, never half a character.
std::string cut_to_columns(std::string_view text, unsigned columns);

/// 1234567 as "1,234,567".
std::string with_thousands(std::uint64_t number);

/// Bytes for people: "812 B", "41.3 kB", "3.69 MB".
std::string human_bytes(double bytes);

}  // namespace planecast
