// A TOML file of options: one key per long option, named as on the command line.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/base/status.hpp"

namespace planecast {

/// One line of a configuration file: the option's name ("off-surface"; '_' was read as '-'), its
/// value or values as text, and where it stands.
struct ConfigEntry {
  std::string name;
  std::vector<std::string> values;
  std::string place;  ///< "FILE:LINE"
};

/// Reads a TOML file of strings, numbers, booleans and flat lists of them. Tables, dates and a key
/// given twice are refused. Errors: kNotFound, kUnreadable, kUsage, naming file and line.
Result<std::vector<ConfigEntry>> read_config_file(const std::filesystem::path& path);

}  // namespace planecast
