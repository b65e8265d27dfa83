#include "apps/recv/status_file.hpp"

#include <cerrno>
#include <cstring>

namespace planecast {

Result<StatusFile> StatusFile::open(const std::string& path) {
  StatusFile out;
  if (path.empty()) return out;
  out.file_.reset(std::fopen(path.c_str(), "a"));
  if (out.file_ == nullptr) {
    return Error{Status::kWriteFailed, "--status: " + path + ": " + std::strerror(errno) +
                                           "; name a file that can be appended to"};
  }
  return out;
}

void StatusFile::write(const std::vector<std::string>& lines) {
  if (file_ == nullptr) return;
  for (const std::string& line : lines) {
    std::fputs(line.c_str(), file_.get());
    std::fputc('\n', file_.get());
  }
  std::fflush(file_.get());
}

}  // namespace planecast
