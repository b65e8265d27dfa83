// The streams that hostile slices are thrown at: a decoder, with its key packet, for the coding of
// every golden vector. So each kind of stream that has a vector is fuzzed. A try costs what its
// frame holds, and ten million are wanted: the frames are those of the vectors, made small.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/pipeline/decoder.hpp"

namespace planecast::test {

/// One stream.
struct GoldenStream {
  std::string name;
  std::vector<std::uint8_t> file;                 ///< its .plc file
  std::vector<std::uint8_t> key;                  ///< sealed key packet
  std::vector<std::vector<std::uint8_t>> slices;  ///< of its frame, sealed
  std::unique_ptr<Decoder> decoder;               ///< has taken the key packet
};

/// All of them, in the order of the golden cases; the process ends when one cannot be made.
/// `folder`: tests/golden.
std::vector<GoldenStream> golden_streams(const std::filesystem::path& folder);

/// A whole file.
std::vector<std::uint8_t> file_bytes(const std::filesystem::path& path);

}  // namespace planecast::test
