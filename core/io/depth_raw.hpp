// Bare depth images: width * height little-endian 16-bit values, row by row, no header.
#pragma once

#include <cstdint>
#include <filesystem>

#include "core/base/status.hpp"
#include "core/cloud/sensor_frame.hpp"

namespace planecast {

/// Reads an image of the given size (1 to kMaxImageSide pixels a side) in the sensor's units, 0 =
/// no reading. Errors: kUsage for a bad size, kNotFound, kUnreadable when the file's size differs.
Result<DepthImage> read_depth_raw(const std::filesystem::path& path, std::uint32_t width,
                                  std::uint32_t height);

/// Writes the values of an image. Errors: kUsage for an inconsistent image, kWriteFailed.
Result<Done> write_depth_raw(const std::filesystem::path& path, const DepthImage& image);

}  // namespace planecast
