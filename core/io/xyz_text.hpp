// Points as text: one point a line, columns apart by space, comma or semicolon. No standard stands
// behind these files, so what is not clear (decimal commas, ragged lines) is refused, not guessed.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

#include "core/base/status.hpp"
#include "core/cloud/sensor_frame.hpp"
#include "core/io/write_report.hpp"

namespace planecast {

/// Reads x y z [the file's unit] as an unorganised cloud. `#` and `//` start a comment; one header
/// line, one line that is only the number of points, and blank lines are allowed. A header (or a
/// comment) that names x, y and z says which columns they are; else they are the first three.
/// Other columns are named in dropped_fields; large offsets go to origin_*.
/// Errors: kNotFound, kUnreadable, naming the line and the mend. Cold path, allocates.
Result<PointCloud> read_xyz_text(const std::filesystem::path& path);

/// The same from a file's bytes; `path` is for messages only. Errors: kUnreadable. Any bytes.
Result<PointCloud> parse_xyz_text(const std::filesystem::path& path,
                                  std::span<const std::uint8_t> file);

/// Writes the valid points, one "x y z" a line, each the shortest decimal that reads back the same;
/// invalid ones are left out and counted in the report. Errors: kWriteFailed.
Result<WriteReport> write_xyz_text(const std::filesystem::path& path, const PointCloud& cloud);

}  // namespace planecast
