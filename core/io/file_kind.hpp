// Which kind of file a name stands for, by its extension, and what to tell about kinds not read.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>

#include "core/base/status.hpp"

namespace planecast {

enum class FileKind : std::uint8_t {
  kDepthPng,
  kDepthRaw,
  kPcd,
  kPly,
  kKittiBin,
  kXyzText,
  kUnread
};

/// Kind by extension, upper or lower case; kUnread for all that Planecast does not read.
FileKind file_kind(const std::filesystem::path& path);

/// Name for messages, e.g. "depth PNG".
std::string_view to_string(FileKind kind) noexcept;

/// True when refusal() has a mend of its own for the extension.
bool is_known_format(const std::filesystem::path& path);

/// The refusal of a file of kind kUnread: its format by name and how to convert it (kUnreadable).
Error refusal(const std::filesystem::path& path);

}  // namespace planecast
