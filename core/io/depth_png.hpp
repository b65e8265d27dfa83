// Depth images as 16-bit grey PNG, and colour PNG for pictures a person looks at; through libspng.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

#include "core/base/status.hpp"
#include "core/cloud/sensor_frame.hpp"

namespace planecast {

/// Reads a 16-bit grey PNG in the sensor's units, 0 = no reading. Any other kind (8-bit, colour,
/// palette, alpha), a wrong CRC, a cut tail and sides over 16384 are refused.
/// Errors: kNotFound, kUnreadable, naming the byte and the mend. Cold path, allocates.
Result<DepthImage> read_depth_png(const std::filesystem::path& path);

/// The same from a file's bytes; `path` is for messages only. Errors: kUnreadable. Any bytes.
Result<DepthImage> parse_depth_png(const std::filesystem::path& path,
                                   std::span<const std::uint8_t> file);

/// Writes a 16-bit grey PNG. Errors: kUsage for an empty or inconsistent image, kWriteFailed.
Result<Done> write_depth_png(const std::filesystem::path& path, const DepthImage& image);

/// Writes an 8-bit RGB PNG from row-major pixels, rgb.size() == width * height * 3.
/// Errors: kUsage for an empty or inconsistent image, kWriteFailed.
Result<Done> write_rgb_png(const std::filesystem::path& path, std::uint32_t width,
                           std::uint32_t height, std::span<const std::uint8_t> rgb);

}  // namespace planecast
