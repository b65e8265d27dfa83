// Whole files in and out of memory. Readers parse spans, so that no parser touches a stream and
// every size is known before anything is believed.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "core/base/status.hpp"

namespace planecast {

/// Largest file that is read, and largest expanded size of a compressed one.
inline constexpr std::uint64_t kMaxFileBytes = std::uint64_t{1} << 31U;

/// Largest number of points that a file may hold.
inline constexpr std::uint64_t kMaxFilePoints = std::uint64_t{1} << 26U;

/// Reads a regular file of at most kMaxFileBytes. Errors: kNotFound, kUnreadable. Cost: one copy.
Result<std::vector<std::uint8_t>> read_file_bytes(const std::filesystem::path& path);

/// Creates or replaces a file. Errors: kWriteFailed, with the system's reason.
Result<Done> write_file_bytes(const std::filesystem::path& path,
                              std::span<const std::uint8_t> bytes);

/// The same for text; line ends are written as they are.
Result<Done> write_file_text(const std::filesystem::path& path, std::string_view text);

/// The bytes seen as characters; the view lives as long as the bytes.
inline std::string_view as_text(std::span<const std::uint8_t> bytes) noexcept {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace planecast
