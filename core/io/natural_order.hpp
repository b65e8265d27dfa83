// The order a person expects of numbered files: 2.png before 10.png.
#pragma once

#include <string_view>

namespace planecast {

/// True when `a` comes before `b`: digit runs compare as numbers of any length, other characters by
/// byte; among equals fewer leading zeros come first. A strict weak order; no allocation,
/// O(length).
bool natural_less(std::string_view a, std::string_view b) noexcept;

}  // namespace planecast
