// Files that appear whole or not at all: written beside their place, then renamed.
#pragma once

#include <filesystem>
#include <functional>

#include "core/base/status.hpp"

namespace planecast {

/// Lets `write` fill a hidden file beside `path` (same folder, same extension) and renames it to
/// `path`, which is replaced. On failure nothing is left behind. kWriteFailed: no such folder, a
/// folder in the file's place, or what the system says; else the error of `write`.
Result<Done> write_whole_file(
    const std::filesystem::path& path,
    const std::function<Result<Done>(const std::filesystem::path&)>& write);

}  // namespace planecast
