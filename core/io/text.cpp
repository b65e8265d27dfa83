#include "core/io/text.hpp"

#include <array>
#include <charconv>
#include <limits>

namespace planecast {
namespace {

template <class T>
void append_shortest(std::string& out, T value) {
  std::array<char, 64> buffer{};
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr;
  out.append(buffer.data(), end);
}

}  // namespace

std::optional<double> parse_number(std::string_view word) noexcept {
  if (!word.empty() && word.front() == '+') {
    word.remove_prefix(1);
    if (!word.empty() && (word.front() == '-' || word.front() == '+')) return std::nullopt;
  }
  double value = 0;
  const char* const end = word.data() + word.size();
  const auto [stop, code] = std::from_chars(word.data(), end, value);
  if (code == std::errc{} && stop == end) return value;
  // What the Microsoft runtime prints for NaN and infinity; both mean "no reading" here.
  if (word.find(".#") != std::string_view::npos) return std::numeric_limits<double>::quiet_NaN();
  return std::nullopt;
}

std::optional<std::uint64_t> parse_count(std::string_view word) noexcept {
  std::uint64_t value = 0;
  const char* const end = word.data() + word.size();
  const auto [stop, code] = std::from_chars(word.data(), end, value);
  if (code != std::errc{} || stop != end) return std::nullopt;
  return value;
}

void append_number(std::string& out, float value) {
  append_shortest(out, value);
}
void append_number(std::string& out, double value) {
  append_shortest(out, value);
}

bool is_space(char c) noexcept {
  return c == ' ' || (c >= '\t' && c <= '\r');
}

std::string_view trimmed(std::string_view text) noexcept {
  while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
  return text;
}

std::string lower_case(std::string_view text) {
  std::string out(text);
  for (char& c : out) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return out;
}

void split_words(std::string_view line, std::vector<std::string_view>& words) {
  words.clear();
  std::size_t at = 0;
  while (at < line.size()) {
    while (at < line.size() && is_space(line[at])) ++at;
    const std::size_t start = at;
    while (at < line.size() && !is_space(line[at])) ++at;
    if (at > start) words.push_back(line.substr(start, at - start));
  }
}

bool LineReader::next(std::string_view& line) noexcept {
  if (offset_ >= text_.size()) return false;
  const std::size_t end = text_.find('\n', offset_);
  line = text_.substr(offset_, end == std::string_view::npos ? end : end - offset_);
  offset_ = end == std::string_view::npos ? text_.size() : end + 1;
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  ++line_;
  return true;
}

}  // namespace planecast
