// KITTI's Velodyne files: bare records of four little-endian float32, x y z intensity, no header.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

#include "core/base/status.hpp"
#include "core/cloud/sensor_frame.hpp"
#include "core/io/write_report.hpp"

namespace planecast {

/// Reads x y z [m, sensor frame] as an unorganised cloud; intensity is named in dropped_fields.
/// Errors: kNotFound; kUnreadable when the size is not a multiple of 16. Cold path, allocates.
Result<PointCloud> read_kitti_bin(const std::filesystem::path& path);

/// The same from a file's bytes; `path` is for messages only. Errors: kUnreadable. Any bytes.
Result<PointCloud> parse_kitti_bin(const std::filesystem::path& path,
                                   std::span<const std::uint8_t> file);

/// Writes the valid points with intensity 0; invalid ones are left out and counted in the report.
/// Errors: kUsage when the cloud has an origin (float32 cannot hold it), kWriteFailed.
Result<WriteReport> write_kitti_bin(const std::filesystem::path& path, const PointCloud& cloud);

}  // namespace planecast
