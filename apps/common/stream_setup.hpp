// From options and a stream's first frame to the encoder's configuration: camera, lattice, noise
// and bound are settled here, once, and each choice that was not the user's is put into words.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/common/cloud_fit.hpp"
#include "apps/common/frame_source.hpp"
#include "apps/common/options.hpp"
#include "core/base/status.hpp"
#include "core/pipeline/encoder.hpp"
#include "core/sensor/z_grid.hpp"

namespace planecast {

struct ListSource;  // of depth images that are coded as lists (points_setup.cpp)

/// A stream ready to encode.
struct StreamSetup {
  EncoderConfig encoder;
  std::vector<std::string> notes;  ///< one sentence a choice, for standard error
  bool cloud_input = false;
  std::shared_ptr<const ZGridTable> grid;  ///< clouds whose z is on the count grid bit for bit
  double bound_m = 0;                      ///< kMetres: the bound the user named
  Contract contract;         ///< as asked for; the encoder's own is tighter by `allowed_share`
  double allowed_share = 0;  ///< clouds: part of each bound that grid and rays may take
  std::shared_ptr<const CameraRays> rays;  ///< clouds coded as depth
  std::optional<RangeLimits> raw_range;    ///< raw clouds: limits of the distance from the origin
  std::shared_ptr<const ListSource> list_source;  ///< lists of points made of depth images
};

/// Settles everything from the first frame. kUsage: an option is missing or contradicts the data
/// (with the mend); kUnreadable: input that this version does not code; kBadConfig.
Result<StreamSetup> setup_stream(const CodecOptions& options, const SourceSensor& sensor,
                                 const SensorFrame& first);

/// The frame as depth counts of the stream's camera (0 = no reading), to submit to the encoder,
/// whose filter applies the range limits. Clouds are turned into optical axes and rounded to the
/// grid. kUnreadable: a frame of another size. kBoundExceeded, clouds only: a point lies off the
/// stream's grid or rays so far that its bound could not be kept; such a frame needs a setup of its
/// own.
Result<Done> to_depth(const StreamSetup& setup, const SensorFrame& frame,
                      std::vector<std::uint16_t>& depth);

/// The frame as points of a raw-cloud stream; readings out of range become holes, and their number
/// is returned. kUnreadable: a frame of another size.
Result<std::uint32_t> to_raw_points(const StreamSetup& setup, const SensorFrame& frame,
                                    std::vector<Point3f>& points);

}  // namespace planecast
