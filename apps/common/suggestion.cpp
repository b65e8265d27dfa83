#include "apps/common/suggestion.hpp"

#include <algorithm>
#include <cctype>
#include <vector>

#include "core/io/nearest_name.hpp"

namespace planecast {
namespace {

std::string folded(std::string_view text) {
  std::string out(text);
  for (char& c : out)
    c = c == '_' ? '-' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return out;
}

}  // namespace

std::string suggestion(std::string_view text, std::span<const std::string> names) {
  const std::string wanted = folded(text);
  if (wanted.empty()) return {};
  std::vector<std::string> plain(names.size());
  std::transform(names.begin(), names.end(), plain.begin(), folded);
  const auto begins = [&](const std::string& name) { return name.starts_with(wanted); };
  const auto index_of = [&](auto place) { return static_cast<std::size_t>(place - plain.begin()); };
  if (std::count_if(plain.begin(), plain.end(), begins) == 1)
    return names[index_of(std::find_if(plain.begin(), plain.end(), begins))];
  const auto near = nearest_name(wanted, plain);
  return near ? names[index_of(std::find(plain.begin(), plain.end(), *near))] : std::string();
}

std::string did_you_mean(std::string_view text, std::span<const std::string> names) {
  const std::string name = suggestion(text, names);
  return name.empty() ? name : "; did you mean '" + name + "'?";
}

}  // namespace planecast
