// What the daemon streams, opened up to its first frame: the source, the link where the source
// needs one, and the stream's settings, stamped with session, clock and boot.
#pragma once

#include <memory>
#include <string>

#include "apps/common/lcm_source.hpp"
#include "apps/common/options.hpp"
#include "apps/common/stop_signals.hpp"
#include "apps/common/stream_setup.hpp"
#include "apps/planecastd/daemon_options.hpp"
#include "transport/lcm_link.hpp"

namespace planecast {

struct StreamInput {
  std::shared_ptr<LcmLink> link;  ///< opened already for "lcm:CHANNEL", else null
  std::unique_ptr<FrameSource> source;
  LcmSource* live = nullptr;  ///< the same source when it is LCM
  SensorFrame first;
  StreamSetup setup;
  double rate_hz = 30;                 ///< told, or the source's own
  std::uint64_t preloaded_frames = 0;  ///< to be decoded into memory before the start
};

/// Opens the input, waits for its first frame and settles the stream. Errors of the sources, of
/// setup_stream and of LcmLink::open; kStopped when a signal ended the wait.
Result<StreamInput> open_input(const DaemonOptions& daemon, const CodecOptions& options,
                               const LcmUrl& url, StopSignals& signals);

}  // namespace planecast
