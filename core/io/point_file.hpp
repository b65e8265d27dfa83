// One door to every point-file format: the extension chooses the reader or writer.
#pragma once

#include <filesystem>

#include "core/base/status.hpp"
#include "core/cloud/sensor_frame.hpp"
#include "core/io/write_report.hpp"

namespace planecast {

/// Reads .pcd, .ply, .bin (KITTI) or text (.xyz .txt .csv .asc .pts) [the file's unit]. Depth
/// images and formats that are not read are refused by name, with the mend. Errors: kNotFound,
/// kUnreadable. Cold path, allocates.
Result<PointCloud> read_point_file(const std::filesystem::path& path);

/// Writes .pcd, .ply, .bin or text (.xyz .txt .asc). The report says how many invalid points the
/// format could not carry (PCD carries all). Errors: kUsage, kWriteFailed.
Result<WriteReport> write_point_file(const std::filesystem::path& path, const PointCloud& cloud);

}  // namespace planecast
