#include "tests/support/data_path.hpp"

#include <cstdlib>

#include "tests/support/source_folder.hpp"

namespace planecast::test {

std::filesystem::path source_folder() {
  return PLANECAST_SOURCE_DIR;
}

std::filesystem::path data_path(const std::string& relative) {
  const char* env = std::getenv("PLANECAST_DATA");
  const std::filesystem::path root = env != nullptr
                                         ? std::filesystem::path(env)
                                         : source_folder().parent_path() / "shared" / "data";
  const std::filesystem::path full = root / relative;
  return std::filesystem::exists(full) ? full : std::filesystem::path();
}

}  // namespace planecast::test
