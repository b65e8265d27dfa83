// What only planecastd is told, beside the options that all commands share.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "apps/common/realtime.hpp"

namespace planecast {

/// Inputs of up to this many frames are decoded into memory before the start.
inline constexpr std::uint64_t kPreloadFrames = 300;
/// Unless --preload was given, no more than this is held [bytes].
inline constexpr std::uint64_t kPreloadBytes = std::uint64_t{512} << 20U;

struct DaemonOptions {
  std::vector<std::string> inputs;
  std::uint8_t stream = 0;  ///< number of the stream on its channel
  std::uint64_t preload = kPreloadFrames;
  bool preload_given = false;
  bool wait = false;          ///< lossless replay: the source waits for room
  bool print_memory = false;  ///< print the memory plan and end
  std::string status_file;    ///< "": none
  RealtimeOptions realtime;
};

}  // namespace planecast
