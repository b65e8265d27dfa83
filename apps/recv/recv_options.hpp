// What only planecast-recv is told, beside the options that all commands share.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "apps/common/options.hpp"
#include "apps/common/realtime.hpp"
#include "core/base/status.hpp"
#include "transport/subscriber.hpp"

namespace planecast {

/// Files that one frame can become.
enum class FrameFormat : std::uint8_t { kPly, kPcd, kPng, kBin };

struct RecvOptions {
  // Sinks
  std::string out_folder;  ///< "": none
  FrameFormat format = FrameFormat::kPly;
  std::string last_file;                    ///< the last complete frame at the end; "": none
  std::string picture_file;                 ///< the same as a picture; "": none
  std::optional<std::string> publish_name;  ///< plain clouds on DRAKE_POINT_CLOUD_<name>
  bool full_cloud = false;                  ///< plain clouds unthinned
  // Reports
  bool stats = false;
  std::string status_file;  ///< "": none
  std::string reference;    ///< "": none
  // The run
  std::uint64_t frames = 0;         ///< end after this many; 0: no end
  std::optional<double> timeout_s;  ///< end when nothing comes for so long
  // Memory
  std::uint16_t streams = 4;
  ImageSize max_size{1280, 1024};
  std::uint32_t deadline_ms = 0;  ///< from a frame's first slice until it is handed on incomplete;
                                  ///< 0: 1000 where every frame counts, else 100
  RealtimeOptions realtime;

  /// Whether any sink takes frames out of the decoder.
  bool has_sinks() const {
    return !out_folder.empty() || !last_file.empty() || !picture_file.empty() ||
           publish_name.has_value();
  }
  /// Whether frames should queue rather than be replaced by newer ones.
  bool keeps_every_frame() const {
    return !out_folder.empty() || !reference.empty() || frames != 0;
  }
};

/// Binds the options above to `app`; both must outlive the parse.
void add_recv_options(CLI::App& app, RecvOptions& options);

/// Refuses what contradicts itself, before anything is opened. kUsage.
Result<Done> check_recv_options(const RecvOptions& options);

/// The subscriber for these options: the assembler's memory follows from the largest frame.
SubscriberConfig subscriber_for(const RecvOptions& options, const CodecOptions& codec);

/// "ply", "pcd", "png", "bin".
const char* extension(FrameFormat format) noexcept;

/// The format that a file's extension names. kUsage.
Result<FrameFormat> format_of(const std::string& path);

}  // namespace planecast
