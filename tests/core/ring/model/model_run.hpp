// What the tests ask of the model; relacy and its macros stay behind it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace planecast::model {

/// Outcome of one simulation: how many orders ran without a fault, and the fault that ended it.
struct Outcome {
  bool holds = false;
  std::uint64_t schedules = 0;
  std::string fault;
};

/// One program over one memory. `weakened` names the order that was made weaker; empty: none, so it
/// has to hold.
struct Case {
  std::string name;
  std::string weakened;
  Outcome (*run)(std::uint64_t schedules) = nullptr;
};

std::vector<Case> sound_cases();
std::vector<Case> mutant_cases();

}  // namespace planecast::model
