#include "apps/common/json_report.hpp"

#include <cmath>
#include <string>

namespace planecast {
namespace {

using Json = nlohmann::ordered_json;

/// Mean of one key over all frames: a number, null where one is not finite, discarded where one is
/// missing or no number.
Json mean_of(const Json& frames, const std::string& key) {
  double sum = 0.0;
  for (const Json& frame : frames) {
    const auto value = frame.find(key);
    if (value == frame.end() || !(value->is_number() || value->is_null()))
      return Json(Json::value_t::discarded);
    sum += value->is_null() ? std::nan("") : value->get<double>();
  }
  const double mean = sum / static_cast<double>(frames.size());
  return std::isfinite(mean) ? Json(mean) : Json(nullptr);
}

}  // namespace

nlohmann::ordered_json report_of(const nlohmann::ordered_json& frames) {
  Json report = {{"frames", Json::array()}, {"mean", Json::object()}};
  for (Json frame : frames) {
    for (auto& [key, value] : frame.items()) {
      if (value.is_number_float() && !std::isfinite(value.get<double>())) value = nullptr;
    }
    report["frames"].push_back(std::move(frame));
  }
  if (report["frames"].empty()) return report;
  for (const auto& [key, value] : report["frames"].front().items()) {
    Json mean = mean_of(report["frames"], key);
    if (!mean.is_discarded()) report["mean"][key] = std::move(mean);
  }
  return report;
}

}  // namespace planecast
