// "Did you mean ...?": the known name nearest to what was written.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace planecast {

/// Insertions, deletions, substitutions and swaps of neighbours that turn one text into the other.
std::size_t edit_distance(std::string_view a, std::string_view b);

/// The name nearest to `text`, or "" when none is near enough to be a slip: at most a third of the
/// letters differ, or `text` is how exactly one name begins. Upper case and '_' count as lower case
/// and '-'.
std::string nearest_name(std::string_view text, std::span<const std::string> names);

/// "; did you mean 'NAME'?", or "" when there is no near name.
std::string did_you_mean(std::string_view text, std::span<const std::string> names);

}  // namespace planecast
