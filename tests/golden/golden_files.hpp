// Whole files in and out for the golden vectors. Not core/io: the vectors also run on boards and
// under emulators, where the libraries behind its readers are not to be had.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "core/base/status.hpp"

namespace planecast::test {

using Bytes = std::vector<std::uint8_t>;

/// Everything in a file. Errors: kNotFound, naming it.
Result<Bytes> read_golden_file(const std::filesystem::path& path);

/// Creates or replaces a file. Errors: kWriteFailed, naming it.
Result<Done> write_golden_file(const std::filesystem::path& path,
                               std::span<const std::uint8_t> bytes);
Result<Done> write_golden_file(const std::filesystem::path& path, std::string_view text);

/// A depth image of little-endian 16-bit counts, row by row, no header. Errors: kNotFound;
/// kUnreadable when the size differs.
Result<std::vector<std::uint16_t>> read_counts(const std::filesystem::path& path,
                                               std::size_t pixels);

}  // namespace planecast::test
