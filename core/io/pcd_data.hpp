// The data part of a PCD file in its three encodings, read against a checked header.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "core/base/status.hpp"
#include "core/io/cloud_builder.hpp"
#include "core/io/pcd_header.hpp"

namespace planecast {

/// Reads header.points points from `file` (the whole file), row-major, in the file's unit.
/// The data size is checked before memory is taken. Bytes after the data are refused unless zero:
/// PCL pads its files to a page.
/// Errors: kUnreadable, naming line or byte and the mend.
Result<std::vector<Point3d>> read_pcd_points(const std::filesystem::path& path,
                                             const PcdHeader& header,
                                             std::span<const std::uint8_t> file);

}  // namespace planecast
