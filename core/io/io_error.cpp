#include "core/io/io_error.hpp"

namespace planecast {

Error file_error(const std::filesystem::path& path, std::string_view place, std::string_view what,
                 std::string_view mend, Status status) {
  std::string message = path.string();
  message += ": ";
  if (!place.empty()) {
    message += place;
    message += ": ";
  }
  message += what;
  message += "; ";
  message += mend;
  return Error{status, std::move(message)};
}

std::string at_byte(std::uint64_t offset) {
  return "byte " + std::to_string(offset);
}

std::string at_line(std::uint64_t line) {
  return "line " + std::to_string(line);
}

std::string in_quotes(std::string_view text) {
  constexpr std::size_t kShown = 40;
  std::string out = "'";
  for (const char c : text.substr(0, kShown)) out += (c >= ' ' && c <= '~') ? c : '?';
  if (text.size() > kShown) out += "...";
  return out + "'";
}

}  // namespace planecast
