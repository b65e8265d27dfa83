// Golden cases to bytes and back to text, the same for the program that writes the vectors and for
// the test that holds them.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/base/status.hpp"
#include "core/pipeline/stream_tables.hpp"
#include "tests/golden/golden_cases.hpp"
#include "tests/golden/golden_files.hpp"

namespace planecast::test {

/// One decoded frame.
struct GoldenFrame {
  std::uint16_t slices = 0;
  std::vector<std::uint16_t> depth;  ///< empty for raw clouds
  std::vector<std::uint8_t> labels;  ///< 1 + surface of each pixel, 0 = none; empty for raw clouds
  std::vector<Point3f> cloud;
};

/// The case's .plc file, by the inline encoder.
Result<Bytes> encode_golden(const GoldenCase& c);

/// Every frame of a whole .plc file, decoded. `limits`: the largest image that is taken. Errors:
/// those of read_plc and of the decoder; kTruncated when anything is missing.
Result<std::vector<GoldenFrame>> decode_golden(std::span<const std::uint8_t> file,
                                               const FrameLimits& limits = {2100, 480, 800});

/// A line a frame: name, frame, slices, readings, CRC-32C of the counts (u16, little-endian) and of
/// the cloud (float32 x, y, z, little-endian), in hexadecimal; "-" where there are no counts.
std::string expected_lines(const std::string& name, const std::vector<GoldenFrame>& frames);

/// A line a point: u, v, count, label and the bits of x, y, z.
std::string dump_lines(const GoldenFrame& frame, std::uint32_t width);

}  // namespace planecast::test
