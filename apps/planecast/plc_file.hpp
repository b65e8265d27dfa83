// A .plc file opened for reading: its bytes, packets and frames, what is missing, and a decoder
// large enough for its streams.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/base/status.hpp"
#include "core/model/stream_config.hpp"
#include "core/pipeline/decoder.hpp"
#include "core/wire/plc_format.hpp"

namespace planecast {

/// Movable; the spans in `contents` point into `bytes`.
struct PlcFile {
  std::string path;
  std::vector<std::uint8_t> bytes;
  PlcContents contents;

  /// True when something is broken, not merely cut off at the end.
  bool damaged() const noexcept;
  /// True when frame i lacks slices because the file ends there.
  bool cut_short(std::size_t i) const noexcept;
  /// Sentences about all that is missing; empty for a complete file.
  std::vector<std::string> missing() const;
};

/// Reads a file. kUsage: not exactly one input; kNotFound; those of read_plc, naming the file.
Result<PlcFile> open_plc(const std::vector<std::string>& inputs);

/// What a key packet says. Those of open_packet and read_key_body.
Result<StreamConfig> config_of(const PlcFile& file, std::span<const std::uint8_t> key_packet);

/// Memory limits that hold every stream of the file. kTooLarge: an image of over kMaxFilePoints.
Result<FrameLimits> limits_of(const PlcFile& file);

}  // namespace planecast
