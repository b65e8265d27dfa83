// Lines, words and numbers of text files, without locale and without allocation per word.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace planecast {

/// Most bytes of the text header of a file; what lies behind is not looked at for one.
inline constexpr std::size_t kMaxHeaderBytes = 64 * 1024;

/// A whole word as a number: decimal, exponent, nan, inf, Windows' "1.#QNAN"; nullopt otherwise.
/// A magnitude beyond double is refused, not turned into infinity.
std::optional<double> parse_number(std::string_view word) noexcept;

/// A whole word as an unsigned decimal; nullopt for signs, fractions, exponents and overflow.
std::optional<std::uint64_t> parse_count(std::string_view word) noexcept;

/// Appends the shortest decimal that reads back as the same value; independent of the locale.
void append_number(std::string& out, float value);
void append_number(std::string& out, double value);

/// True for space, tab, line feed, carriage return, vertical tab and form feed.
bool is_space(char c) noexcept;

/// The text without space at its ends.
std::string_view trimmed(std::string_view text) noexcept;

/// ASCII letters in lower case.
std::string lower_case(std::string_view text);

/// Splits at runs of space; `words` is cleared first and keeps its memory between calls.
void split_words(std::string_view line, std::vector<std::string_view>& words);

/// Walks over the lines of a text, without their "\n" or "\r\n".
class LineReader {
 public:
  explicit LineReader(std::string_view text, std::size_t first_line = 1) noexcept
      : text_(text), line_(first_line - 1) {}

  /// Takes the next line; false at the end. A last line without line end counts as a line.
  bool next(std::string_view& line) noexcept;

  /// Number of the line that next() gave last.
  std::size_t line() const noexcept { return line_; }
  /// Offset of the first byte that next() has not given yet.
  std::size_t offset() const noexcept { return offset_; }

 private:
  std::string_view text_;
  std::size_t offset_ = 0;
  std::size_t line_;
};

}  // namespace planecast
