#include "apps/common/config_file.hpp"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <fstream>
#include <optional>
#include <system_error>

namespace planecast {
namespace {

/// A number as the command line would have it, without a useless ".0".
std::string text_of(double number) {
  return fmt::format("{}", number);
}

std::optional<std::string> text_of(const toml::node& node) {
  if (const auto* text = node.as_string()) return text->get();
  if (const auto* whole = node.as_integer()) return std::to_string(whole->get());
  if (const auto* real = node.as_floating_point()) return text_of(real->get());
  if (const auto* truth = node.as_boolean()) return truth->get() ? "true" : "false";
  return std::nullopt;
}

/// The values of one key: one, or those of a flat list; nothing for what is neither.
std::optional<std::vector<std::string>> values_of(const toml::node& node) {
  if (const auto text = text_of(node)) return std::vector<std::string>{*text};
  const toml::array* list = node.as_array();
  if (list == nullptr) return std::nullopt;
  std::vector<std::string> values;
  for (const toml::node& element : *list) {
    const auto text = text_of(element);
    if (!text) return std::nullopt;
    values.push_back(*text);
  }
  return values;
}

Result<std::vector<ConfigEntry>> entries_of(const toml::table& table, const std::string& file) {
  std::vector<ConfigEntry> entries;
  for (const auto& [key, node] : table) {
    ConfigEntry entry;
    entry.name = std::string(key.str());
    std::replace(entry.name.begin(), entry.name.end(), '_', '-');
    entry.place = fmt::format("{}:{}", file, key.source().begin.line);
    const auto values = values_of(node);
    if (!values) {
      return {Status::kUsage,
              fmt::format("{}: '{}' is neither a value nor a list of values; options stand in no "
                          "table, one a line: tolerance = \"10mm\"",
                          entry.place, key.str())};
    }
    for (const ConfigEntry& other : entries) {
      if (other.name == entry.name)
        return {Status::kUsage, fmt::format("{}: '{}' is set twice", entry.place, entry.name)};
    }
    entry.values = *values;
    entries.push_back(std::move(entry));
  }
  return entries;
}

}  // namespace

Result<std::vector<ConfigEntry>> read_config_file(const std::filesystem::path& path) {
  const std::string file = path.string();
  std::error_code code;
  if (!std::filesystem::exists(path, code))
    return {Status::kNotFound, file + ": no such configuration file"};
  std::ifstream stream(path, std::ios::binary);
  if (!stream || std::filesystem::is_directory(path, code))
    return {Status::kUnreadable, file + ": cannot be read as a configuration file"};
  try {
    return entries_of(toml::parse(stream, file), file);
  } catch (const toml::parse_error& error) {
    return {Status::kUsage, fmt::format("{}:{}: {}; write one option a line: tolerance = \"10mm\"",
                                        file, error.source().begin.line, error.description())};
  }
}

}  // namespace planecast
