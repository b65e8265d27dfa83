// The one shape of an io message: "FILE: PLACE: WHAT; MEND". A person reads it and knows what to
// do.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "core/base/status.hpp"

namespace planecast {

/// What to do about a body that holds less than its header says.
inline constexpr std::string_view kCutShort =
    "the file is cut short, or its header is wrong: get it anew";

/// Builds the Error of a file: `place` ("line 7", "byte 12") may be empty, `mend` says what to do.
Error file_error(const std::filesystem::path& path, std::string_view place, std::string_view what,
                 std::string_view mend, Status status = Status::kUnreadable);

/// "byte N", counted from 0 at the start of the file.
std::string at_byte(std::uint64_t offset);

/// "line N", counted from 1.
std::string at_line(std::uint64_t line);

/// The text in quotes, cut to 40 characters, with unprintable bytes shown as '?'.
std::string in_quotes(std::string_view text);

}  // namespace planecast
