// The table that eval prints for people: one row a frame, then the mean.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace planecast {

/// Two lines: column names and units.
std::string table_head();

/// One row of the keys of figures_of(); keys that are missing or null stand as "-".
std::string table_row(const std::string& name, const nlohmann::ordered_json& figures);

}  // namespace planecast
