// The streams that hostile slices are thrown at: a decoder, with its key packet, for every golden
// vector of a small image. So each kind of stream that has a vector is fuzzed.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/pipeline/decoder.hpp"

namespace planecast::test {

/// One stream. The slices are those of the vector's frames, sealed.
struct GoldenStream {
  std::string name;
  std::vector<std::uint8_t> key;                  ///< sealed key packet
  std::vector<std::vector<std::uint8_t>> slices;  ///< of its first frame
  std::unique_ptr<Decoder> decoder;               ///< has taken the key packet
};

/// All of them, by name; the process ends when a vector cannot be read.
std::vector<GoldenStream> golden_streams(const std::filesystem::path& folder);

/// A whole file.
std::vector<std::uint8_t> file_bytes(const std::filesystem::path& path);

}  // namespace planecast::test
