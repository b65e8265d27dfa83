// Packets and files that each end with one status, made by spoiling golden vectors.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/status.hpp"
#include "core/pipeline/decoder.hpp"
#include "tests/golden/golden_vectors.hpp"

namespace planecast::test {

/// A spoilt packet or file. `name` begins with what it is: key_, slice_ (of the depth stream), raw_
/// (a slice of the raw stream) or file_. Its file is STATUS__name.bin.
struct BadPacket {
  Status status = Status::kOk;
  std::string name;
  Bytes bytes;
  std::string file_name() const { return std::string(to_string(status)) + "__" + name + ".bin"; }
};

/// Decodes spoilt packets after the good key packets of a depth and of a raw stream.
class BadBench {
 public:
  /// .plc files with at least one frame each: a depth stream, raw clouds, a list of points, and one
  /// that begins with patches.
  BadBench(std::span<const std::uint8_t> depth, std::span<const std::uint8_t> raw,
           std::span<const std::uint8_t> points, std::span<const std::uint8_t> patches);

  /// What becomes of the bytes: the status of read_plc, Decoder::set_key or Decoder::add.
  Status decode(std::string_view name, std::span<const std::uint8_t> bytes) const;

  Bytes key, depth_slice, raw_key, raw_slice, points_key, points_slice, patches_key, patches_slice;

 private:
  std::unique_ptr<Decoder> depth_decoder_, raw_decoder_, points_decoder_,
      patches_decoder_;  ///< with their key packets
};

/// All of them; kBadConfig with the name when one does not end with its status.
Result<std::vector<BadPacket>> bad_packets(const BadBench& bench,
                                           std::span<const std::uint8_t> small_file);

}  // namespace planecast::test
