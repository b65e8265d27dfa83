// The one JSON shape of `eval` and its like: {"frames": [...], "mean": {...}}.
#pragma once

#include <nlohmann/json.hpp>

namespace planecast {

/// Wraps an array of objects, one a frame, and adds the mean of every key that holds a number in
/// all frames. A number that is not finite stands as null (JSON has no infinity), and so does its
/// mean. Keys keep their order. No frames give an empty mean.
nlohmann::ordered_json report_of(const nlohmann::ordered_json& frames);

}  // namespace planecast
