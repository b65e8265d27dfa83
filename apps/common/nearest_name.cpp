#include "apps/common/nearest_name.hpp"

#include <algorithm>
#include <cctype>
#include <vector>

namespace planecast {
namespace {

std::string folded(std::string_view text) {
  std::string out(text);
  for (char& c : out)
    c = c == '_' ? '-' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return out;
}

/// The one name that begins with `text`, or nullptr.
const std::string* only_completion(const std::string& text, std::span<const std::string> names) {
  const std::string* only = nullptr;
  for (const std::string& name : names) {
    if (!folded(name).starts_with(text)) continue;
    if (only != nullptr) return nullptr;
    only = &name;
  }
  return only;
}

}  // namespace

std::size_t edit_distance(std::string_view a, std::string_view b) {
  // Rows of the optimal-string-alignment table: two back, one back, current.
  std::vector<std::size_t> before(b.size() + 1), last(b.size() + 1), row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) last[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t change = last[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, change});
      const bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (swapped) row[j] = std::min(row[j], before[j - 2] + 1);
    }
    std::swap(before, last);
    std::swap(last, row);
  }
  return last[b.size()];
}

std::string nearest_name(std::string_view text, std::span<const std::string> names) {
  const std::string wanted = folded(text);
  if (wanted.empty()) return {};
  if (const std::string* only = only_completion(wanted, names)) return *only;
  const std::string* best = nullptr;
  std::size_t best_distance = std::max<std::size_t>(1, wanted.size() / 3) + 1;
  for (const std::string& name : names) {
    const std::size_t distance = edit_distance(wanted, folded(name));
    if (distance >= best_distance) continue;
    best_distance = distance;
    best = &name;
  }
  return best == nullptr ? std::string() : *best;
}

std::string did_you_mean(std::string_view text, std::span<const std::string> names) {
  const std::string name = nearest_name(text, names);
  return name.empty() ? name : "; did you mean '" + name + "'?";
}

}  // namespace planecast
