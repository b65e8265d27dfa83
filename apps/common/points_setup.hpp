// Settles streams of points without order, and turns frames into their lists.
#pragma once

#include <vector>

#include "apps/common/stream_setup.hpp"

namespace planecast {

/// Takes a depth stream's settled camera as what depth images are turned into points by. Before
/// setup_points() of such a stream. kBadConfig, kOutOfArena.
Result<Done> settle_list_source(const StreamConfig& depth, StreamSetup& setup);

/// Settles a stream whose frames are lists of points: grid, bound, noise, memory, origin. The
/// tolerance of `setup` is settled already. kUsage: a noise that grows with depth; kUnreadable: too
/// many points; kFrameTooLarge: more than --max-points.
Result<Done> setup_points(const CodecOptions& options, const SourceSensor& sensor,
                          const SensorFrame& first, StreamSetup& setup);

/// Gives a decoded list the zero of its stream, which files then carry or add.
void set_origin(const StreamConfig& config, PointCloud& cloud);

/// The frame's finite points [m], relative to the stream's origin (config.axes). kFrameTooLarge:
/// more than the stream's max_points, with the figure that would fit; kBoundExceeded: its own
/// origin is too far from the stream's; kUnreadable: a depth image of another size.
Result<Done> to_points(const StreamSetup& setup, const SensorFrame& frame,
                       std::vector<Point3f>& points);

}  // namespace planecast
