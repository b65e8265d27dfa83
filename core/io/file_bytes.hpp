// Whole files in and out of memory. Readers parse spans, so that no parser touches a stream and
// every size is known before anything is believed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "core/base/status.hpp"

namespace planecast {

/// Binary places taken off the limits below: with addresses of 32 bits they are a quarter,
/// since the file, its points and its cloud lie in memory together.
inline constexpr unsigned kLessOn32Bit = sizeof(std::size_t) < 8 ? 2 : 0;

/// Largest file that is read, and largest expanded size of a compressed one.
inline constexpr std::size_t kMaxFileBytes = std::size_t{1} << (31U - kLessOn32Bit);

/// Largest number of points that a file may hold.
inline constexpr std::size_t kMaxFilePoints = std::size_t{1} << (26U - kLessOn32Bit);

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
