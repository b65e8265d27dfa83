// One received frame as a file: its name and its bytes. Cold path, the sink thread's.
#pragma once

#include <filesystem>
#include <string>

#include "apps/recv/recv_options.hpp"
#include "apps/recv/sink_queue.hpp"
#include "core/base/status.hpp"

namespace planecast {

/// "camera-000012.ply": the frame id that the sender gave (characters that do not belong in a file
/// name as '_'), "_N" for stream N above 0, ".N" for the N-th sender of the stream from the second
/// on, and ".partial" where slices are missing.
std::string frame_file_name(const SinkFrame& frame, FrameFormat format);

/// Writes the frame's cloud, or for kPng its depth image in counts. kUsage: a raw cloud has no
/// depth image; kWriteFailed.
Result<Done> write_frame(const SinkFrame& frame, FrameFormat format,
                         const std::filesystem::path& path);

}  // namespace planecast
