// The data part of a PLY file: walks every element, also those that are skipped, so that a file cut
// short anywhere is noticed.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "core/base/status.hpp"
#include "core/io/cloud_builder.hpp"
#include "core/io/ply_header.hpp"

namespace planecast {

/// Reads the vertices of `file` (the whole file) in its own unit. Counts are checked against the
/// file's size before memory is taken. Errors: kUnreadable, naming line or byte and the mend.
Result<std::vector<Point3d>> read_ply_points(const std::filesystem::path& path,
                                             const PlyHeader& header,
                                             std::span<const std::uint8_t> file);

}  // namespace planecast
