// The text header of a PCD file (versions .5, .6 and .7), checked before a byte of data is
// believed.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "core/base/status.hpp"
#include "core/cloud/sensor_frame.hpp"

namespace planecast {

enum class PcdEncoding : std::uint8_t { kAscii, kBinary, kBinaryCompressed };

struct PcdField {
  std::string name;
  char type = 'F';           ///< 'F', 'I' or 'U'
  std::uint32_t size = 4;    ///< bytes of one element
  std::uint32_t count = 1;   ///< elements
  std::uint32_t offset = 0;  ///< bytes before it in one point
  std::uint32_t word = 0;    ///< words before it in one ascii line
  std::uint32_t bytes() const noexcept { return size * count; }
};

struct PcdHeader {
  std::vector<PcdField> fields;
  std::array<std::size_t, 3> xyz{};  ///< index of x, y and z in fields: F, 4 or 8 bytes, count 1
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::size_t points = 0;  ///< == width * height <= kMaxFilePoints
  std::uint32_t point_bytes = 0;
  std::uint32_t point_words = 0;
  Pose viewpoint;
  PcdEncoding encoding = PcdEncoding::kAscii;
  std::size_t data_offset = 0;  ///< first byte after the DATA line
  std::size_t data_line = 1;    ///< number of the line that starts there

  /// What the header promises in binary; may be more than the file has, or than a 32-bit machine
  /// can address.
  std::uint64_t data_bytes() const noexcept { return std::uint64_t{points} * point_bytes; }
};

/// Reads and checks the header at the start of `file`; `path` is for messages only.
/// Errors: kUnreadable, naming the line and the mend.
Result<PcdHeader> parse_pcd_header(const std::filesystem::path& path,
                                   std::span<const std::uint8_t> file);

}  // namespace planecast
