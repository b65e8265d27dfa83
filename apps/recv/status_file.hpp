// The file of --status: lines appended for a script that follows it, each flushed at once.
#pragma once

#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "core/base/status.hpp"

namespace planecast {

class StatusFile {
 public:
  /// Opens for appending; "" makes one that takes lines and does nothing. kWriteFailed.
  static Result<StatusFile> open(const std::string& path);

  void write(const std::vector<std::string>& lines);

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  std::unique_ptr<std::FILE, Close> file_;
};

}  // namespace planecast
