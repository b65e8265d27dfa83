// The steps of setup_stream() that depth images and clouds share: each settles one part of the
// stream's configuration from the options, the source and the first frame.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "apps/common/stream_setup.hpp"

namespace planecast {

/// Tolerance, off-surface choice and effort of the options.
void settle_tolerance(const CodecOptions& options, StreamSetup& setup);

/// The camera given by the options, for an image of this size; nothing when none was given.
/// kUsage: a preset for an image of another shape.
Result<std::optional<Intrinsics>> given_camera(const CodecOptions& options, std::uint32_t width,
                                               std::uint32_t height, const std::string& name,
                                               std::vector<std::string>& notes);

/// Rounds a camera to the wire. kBadConfig.
Result<Done> settle_camera(const Intrinsics& intrinsics, std::uint32_t width, std::uint32_t height,
                           StreamConfig& config);

/// The levels that the counts lie on, if any.
void settle_lattice(const std::vector<std::uint16_t>& depth, StreamSetup& setup);

/// The noise model of the options, the preset, the source, or a stated guess; and the contract.
void settle_noise(const CodecOptions& options, const SourceSensor& sensor, StreamSetup& setup);

/// The range limits in counts of the settled camera.
void settle_range(const CodecOptions& options, StreamSetup& setup);

/// Settles a stream of organised clouds (cloud_setup.cpp).
Result<Done> setup_cloud(const CodecOptions& options, const SourceSensor& sensor,
                         const SensorFrame& first, StreamSetup& setup);

}  // namespace planecast
