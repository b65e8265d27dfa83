// "; did you mean ...?": the end of every message about a name that is not known.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace planecast {

/// The name that `text` was probably meant to be, or "" when none is near: the one name that begins
/// with it, else the nearest by slips of the finger (core/io/nearest_name.hpp). Upper case and '_'
/// count as lower case and '-'.
std::string suggestion(std::string_view text, std::span<const std::string> names);

/// "; did you mean 'NAME'?", or "" when there is no suggestion.
std::string did_you_mean(std::string_view text, std::span<const std::string> names);

}  // namespace planecast
