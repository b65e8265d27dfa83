// From options and a stream's first frame to the encoder's configuration: camera, lattice, noise
// and bound are settled here, once, and each choice that was not the user's is put into words.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "apps/common/frame_source.hpp"
#include "apps/common/options.hpp"
#include "core/base/status.hpp"
#include "core/pipeline/encoder.hpp"

namespace planecast {

/// A stream ready to encode.
struct StreamSetup {
  EncoderConfig encoder;
  std::vector<std::string> notes;  ///< one sentence a choice, for standard error
  bool cloud_input = false;
  bool exact_grid = false;  ///< clouds: z lies on the camera's count grid bit for bit
  double bound_m = 0;       ///< kMetres: the bound the user named
};

/// Settles everything from the first frame. kUsage: an option is missing or contradicts the data
/// (with the mend); kBadConfig.
Result<StreamSetup> setup_stream(const CodecOptions& options, const SourceSensor& sensor,
                                 const SensorFrame& first);

/// The frame as depth counts of the stream's camera (0 = no reading). Clouds are turned into
/// optical axes and rounded to the grid. kUnreadable: a frame of another size or, for clouds that
/// were proven exact, off the grid.
Result<Done> to_depth(const StreamSetup& setup, const SensorFrame& frame,
                      std::vector<std::uint16_t>& depth);

}  // namespace planecast
