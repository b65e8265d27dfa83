// "Did you mean": the known name nearest to one that was mistyped.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace planecast {

/// The candidate with the smallest edit distance to `wanted`, when that is at most a third of the
/// length of `wanted` (and at least 1 edit is allowed); the first of several. nullopt when none is
/// that near. Cold path; O(sum of candidate lengths * wanted length), names over 256 bytes ignored.
std::optional<std::string> nearest_name(std::string_view wanted,
                                        std::span<const std::string> candidates);

}  // namespace planecast
