#include "apps/planecastd/stream_input.hpp"

#include <fmt/format.h>

#include <random>

#include "apps/common/boot_id.hpp"
#include "apps/planecastd/memory_plan.hpp"
#include "core/wire/frame_pack.hpp"
#include "core/wire/point_pack.hpp"
#include "core/wire/raw_pack.hpp"
#include "transport/envelope.hpp"
#include "transport/wake.hpp"

namespace planecast {
namespace {

constexpr std::int64_t kInputPollNs = 50'000'000;
constexpr std::int64_t kPatienceNs = 2'000'000'000;  // until the user is told what is waited for

bool is_live(const DaemonOptions& daemon) {
  return !daemon.inputs.empty() && daemon.inputs.front().starts_with(kLcmInputPrefix);
}

Result<Done> open_live(const DaemonOptions& daemon, const LcmUrl& url, StreamInput& input) {
  if (daemon.inputs.size() > 1)
    return {Status::kUsage, "lcm:CHANNEL is an input of its own; give it alone"};
  const std::string channel = daemon.inputs.front().substr(kLcmInputPrefix.size());
  if (const auto checked = check_channel(channel); !checked) return checked.error();
  auto link = LcmLink::open(url, true);
  if (!link) return link.error();
  auto source = LcmSource::open(channel, *link);
  if (!source) return source.error();
  input.link = std::move(*link);
  input.live = source->get();
  input.source = std::move(*source);
  return Done{};
}

Result<Done> first_live_frame(StreamInput& input, const std::string& name, StopSignals& signals) {
  std::int64_t tell_ns = monotonic_ns() + kPatienceNs;
  std::string told;
  while (!input.live->next_within(input.first, kInputPollNs)) {
    if (signals.asked()) return {Status::kStopped, "stopped before the first cloud came"};
    const std::string refusal = input.live->refusal();
    if (!refusal.empty() && refusal != told) {
      fmt::print(stderr, "planecastd: refused: {}\n", refusal);
    } else if (monotonic_ns() > tell_ns) {
      fmt::print(stderr, "planecastd: waiting for drake.lcmt_point_cloud on {}\n", name);
      tell_ns = std::numeric_limits<std::int64_t>::max();
    }
    told = refusal;
  }
  return Done{};
}

Result<Done> first_frame(StreamInput& input) {
  const auto got = input.source->next(input.first);
  if (!got) return got.error();
  if (!*got) return {Status::kNotFound, "the input holds no frame"};
  return Done{};
}

// Stamps of a live source are its own. What is played is stamped here, and its latency can be told
// by every process of this boot.
void settle_clock(const StreamInput& input, StreamConfig& config) {
  if (input.live != nullptr) {
    config.clock = ClockDomain::kSensor;
    config.epoch_ns = input.first.stamp_ns;
  } else {
    config.clock = ClockDomain::kMonotonic;
    config.boot_id = boot_id_hash();
    config.epoch_ns = monotonic_ns();
  }
}

Result<Done> settle_slices(const CodecOptions& options, EncoderConfig& encoder) {
  const std::size_t least =
      kEnvelopeOverheadBytes + (encoder.stream.kind == FrameKind::kRawCloud ? kMinRawSliceBytes
                                : encoder.stream.kind == FrameKind::kPoints ? kMinPointSliceBytes
                                                                            : kMinSliceBytes);
  constexpr std::size_t kMost = kEnvelopeOverheadBytes + kMaxPacketBytes;
  if (options.slice_bytes < least || options.slice_bytes > kMost)
    return {Status::kUsage, fmt::format("--slice-bytes {}: this stream needs {} to {}, the LCM "
                                        "envelope of {} bytes included",
                                        options.slice_bytes, least, kMost, kEnvelopeOverheadBytes)};
  encoder.stages.slice_bytes = max_packet_bytes(options.slice_bytes);
  return Done{};
}

std::uint64_t preloaded_frames(const DaemonOptions& daemon, const StreamInput& input) {
  const std::uint64_t count = input.source->count().value_or(0);
  if (input.live != nullptr || count > daemon.preload) return 0;
  const std::uint64_t bytes = count * frame_bytes(input.setup.encoder.stream);
  return daemon.preload_given || bytes <= kPreloadBytes ? count : 0;
}

}  // namespace

Result<StreamInput> open_input(const DaemonOptions& daemon, const CodecOptions& options,
                               const LcmUrl& url, StopSignals& signals) {
  StreamInput input;
  if (is_live(daemon)) {
    if (const auto done = open_live(daemon, url, input); !done) return done.error();
    if (const auto done = first_live_frame(input, daemon.inputs.front(), signals); !done)
      return done.error();
  } else {
    auto source = open_source(daemon.inputs, options);
    if (!source) return source.error();
    input.source = std::move(*source);
    if (const auto done = first_frame(input); !done) return done.error();
  }
  input.rate_hz = options.rate_hz.value_or(input.source->sensor().rate_hz);
  auto setup = setup_stream(options, input.source->sensor(), input.first);
  if (!setup) return setup.error();
  input.setup = std::move(*setup);
  EncoderConfig& encoder = input.setup.encoder;
  encoder.stream.stream = daemon.stream;
  encoder.stream.session = std::random_device{}();
  settle_clock(input, encoder.stream);
  if (const auto done = settle_slices(options, encoder); !done) return done.error();
  encoder.runner.mode = options.threads == Threads::kInline ? RunMode::kInline : RunMode::kThreads;
  input.preloaded_frames = preloaded_frames(daemon, input);
  return input;
}

}  // namespace planecast
