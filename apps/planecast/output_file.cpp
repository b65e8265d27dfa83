#include "apps/planecast/output_file.hpp"

#include <unistd.h>

#include <string>
#include <system_error>

namespace planecast {

namespace fs = std::filesystem;

Result<Done> write_whole_file(const fs::path& path,
                              const std::function<Result<Done>(const fs::path&)>& write) {
  std::error_code code;
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  if (!fs::is_directory(folder, code)) {
    return Error{Status::kWriteFailed,
                 path.string() + ": there is no folder " + folder.string() + "; make it first"};
  }
  if (fs::is_directory(path, code))
    return Error{Status::kWriteFailed, path.string() + ": is a folder; name a file in it"};
  const fs::path part = folder / ("." + path.stem().string() + ".part" + std::to_string(getpid()) +
                                  path.extension().string());
  auto done = write(part);
  if (done.ok()) {
    fs::rename(part, path, code);
    if (code) done = Error{Status::kWriteFailed, path.string() + ": " + code.message()};
  }
  if (!done.ok()) fs::remove(part, code);
  return done;
}

}  // namespace planecast
