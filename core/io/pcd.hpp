// PCD, the file format of the Point Cloud Library: read in all three encodings, written as binary.
// Our own reader because PCL is several hundred packages; docs: PCL's "PCD file format" page.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

#include "core/base/status.hpp"
#include "core/cloud/sensor_frame.hpp"
#include "core/io/write_report.hpp"

namespace planecast {

/// Reads a PCD file of version .5, .6 or .7: ascii, binary or binary_compressed, x y z as float32
/// or float64 in any order [the file's unit, sensor frame]. Other fields are named in
/// dropped_fields. NaN points are kept; large offsets go to origin_*; VIEWPOINT to viewpoint.
/// Errors: kNotFound, kUnreadable, with line or byte and the mend. Cold path, allocates.
Result<PointCloud> read_pcd(const std::filesystem::path& path);

/// The same from a file's bytes; `path` is for messages only. Errors: kUnreadable. Any bytes.
Result<PointCloud> parse_pcd(const std::filesystem::path& path, std::span<const std::uint8_t> file);

/// Writes binary PCD 0.7 in the cloud's shape, invalid points as NaN (none is left out).
/// Coordinates are float32, or float64 with the origin added when the cloud has one. Errors: kUsage
/// when points.size() is not width * height, kWriteFailed.
Result<WriteReport> write_pcd(const std::filesystem::path& path, const PointCloud& cloud);

}  // namespace planecast
