// PLY, the polygon file format: its vertices are read from all three encodings, faces are skipped.
// Written as binary little endian, which every viewer opens.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

#include "core/base/status.hpp"
#include "core/cloud/sensor_frame.hpp"
#include "core/io/write_report.hpp"

namespace planecast {

/// Reads the vertex element of a PLY 1.0 file [the file's unit] as an unorganised cloud. Other
/// properties and elements are named in dropped_fields; large offsets go to origin_*.
/// Errors: kNotFound, kUnreadable, with line or byte and the mend. Cold path, allocates.
Result<PointCloud> read_ply(const std::filesystem::path& path);

/// The same from a file's bytes; `path` is for messages only. Errors: kUnreadable. Any bytes.
Result<PointCloud> parse_ply(const std::filesystem::path& path, std::span<const std::uint8_t> file);

/// Writes the valid points as binary little endian x y z: float, or double with the origin added
/// when the cloud has one. PLY has no grid and no sign for "no reading": invalid points are left
/// out and counted in the report. Errors: kWriteFailed.
Result<WriteReport> write_ply(const std::filesystem::path& path, const PointCloud& cloud);

}  // namespace planecast
