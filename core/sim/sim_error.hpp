// The one shape of a simulator's message: which number of its configuration is wrong, and what it
// may be.
#pragma once

#include <cstdio>

#include "core/base/status.hpp"

namespace planecast {

/// kBadConfig: `name` has this value; `mend` says its unit and range.
inline Error bad_value(const char* name, double value, const char* mend) {
  char text[160];
  std::snprintf(text, sizeof text, "simulator: %s = %g: %s", name, value, mend);
  return {Status::kBadConfig, text};
}

}  // namespace planecast
