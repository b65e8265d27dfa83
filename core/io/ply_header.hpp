// The text header of a PLY file: its elements and their properties, checked before any data.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "core/base/status.hpp"

namespace planecast {

enum class PlyEncoding : std::uint8_t { kAscii, kLittleEndian, kBigEndian };
enum class PlyType : std::uint8_t { kI8, kU8, kI16, kU16, kI32, kU32, kF32, kF64 };

/// Bytes of a value in a binary file.
std::size_t ply_type_bytes(PlyType type) noexcept;

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::kF32;  ///< of the value, or of a list's items
  bool is_list = false;
  PlyType count_type = PlyType::kU8;  ///< of a list's length; never a float
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;
};

struct PlyHeader {
  PlyEncoding encoding = PlyEncoding::kAscii;
  std::vector<PlyElement> elements;
  std::size_t vertex = 0;       ///< index of the vertex element: scalar x, y and z once each
  std::size_t data_offset = 0;  ///< first byte after the end_header line
  std::size_t data_line = 1;    ///< number of the line that starts there
};

/// Reads and checks the header at the start of `file`; `path` is for messages only.
/// Errors: kUnreadable, naming the line and the mend.
Result<PlyHeader> parse_ply_header(const std::filesystem::path& path,
                                   std::span<const std::uint8_t> file);

}  // namespace planecast
