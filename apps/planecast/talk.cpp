#include <fmt/core.h>

#include <cstdio>

#include "apps/planecast/commands.hpp"

namespace planecast {

ExitCode complain(const Error& error) {
  fmt::print(stderr, "planecast: {}\n", error.message);
  return exit_code(error.status);
}

void tell(const std::vector<std::string>& notes) {
  for (const std::string& note : notes) fmt::print(stderr, "planecast: {}\n", note);
}

}  // namespace planecast
