#include "apps/planecast/eval_table.hpp"

#include <fmt/format.h>

#include <string_view>

namespace planecast {
namespace {

constexpr int kNameWidth = 24;

struct Column {
  const char* key;
  const char* head;
  const char* unit;
  int width;
  int decimals;
};

constexpr Column kColumns[] = {
    {"points_in", "in", "points", 8, 0},
    {"points_out", "out", "points", 8, 0},
    {"points_dropped", "dropped", "points", 8, 0},
    {"points_out_of_range", "off range", "points", 10, 0},
    {"bytes", "size", "bytes", 9, 0},
    {"bits_per_point", "bits", "/point", 7, 3},
    {"wire_bytes", "wire", "bytes", 9, 0},
    {"slices", "slices", "", 7, 0},
    {"ratio_percent", "saved", "%", 7, 2},
    {"d1_ab_mm", "d1 ab", "mm", 8, 3},
    {"d1_ba_mm", "d1 ba", "mm", 8, 3},
    {"d1_mm", "d1", "mm", 8, 3},
    {"d2_mm", "d2", "mm", 8, 3},
    {"max_mm", "max", "mm", 9, 3},
    {"bound_utilisation", "bound", "used", 7, 3},
    {"encode_ms", "encode", "ms CPU", 8, 2},
    {"decode_ms", "decode", "ms CPU", 8, 2},
    {"surfaces", "surfaces", "", 9, 0},
};

std::string cell(const nlohmann::ordered_json& figures, const Column& column) {
  const auto value = figures.find(column.key);
  if (value == figures.end() || !value->is_number()) return "-";
  return fmt::format("{:.{}f}", value->get<double>(), column.decimals);
}

}  // namespace

std::string table_head() {
  std::string names = fmt::format("{:<{}}", "frame", kNameWidth);
  std::string units = fmt::format("{:<{}}", "", kNameWidth);
  for (const Column& column : kColumns) {
    names += fmt::format("{:>{}}", column.head, column.width);
    units += fmt::format("{:>{}}", column.unit, column.width);
  }
  return names + "\n" + units;
}

std::string table_row(const std::string& name, const nlohmann::ordered_json& figures) {
  const std::string_view shown = std::string_view(name).substr(0, kNameWidth - 1);
  std::string row = fmt::format("{:<{}}", shown, kNameWidth);
  for (const Column& column : kColumns)
    row += fmt::format("{:>{}}", cell(figures, column), column.width);
  return row;
}

}  // namespace planecast
