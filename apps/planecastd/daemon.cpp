#include "apps/planecastd/daemon.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>

#include "apps/common/memory_fit.hpp"
#include "apps/planecastd/balance.hpp"
#include "apps/planecastd/frame_player.hpp"
#include "apps/planecastd/memory_plan.hpp"
#include "apps/planecastd/status_report.hpp"
#include "apps/planecastd/stream_input.hpp"
#include "core/pipeline/watchdog.hpp"
#include "core/pipeline/worker_thread.hpp"

namespace planecast {
namespace {

constexpr std::int64_t kPollNs = 20'000'000;
constexpr std::int64_t kSecondNs = 1'000'000'000;
constexpr std::int64_t kFlushNs = 3 * kSecondNs;
constexpr std::int64_t kFlushAfterSignalNs = kSecondNs / 2;

ExitCode complain(const Error& error) {
  fmt::print(stderr, "planecastd: {}\n", error.message);
  return exit_code(error.status);
}

// Members in the order in which they depend on each other.
struct Daemon {
  Daemon(const DaemonOptions& given, const CodecOptions& codec, StopSignals& stop,
         StreamInput opened)
      : daemon(given), options(codec), signals(stop), input(std::move(opened)) {}

  const DaemonOptions& daemon;
  const CodecOptions& options;
  StopSignals& signals;
  StreamInput input;
  MemoryNeeds needs;
  DaemonMemory memory;
  std::unique_ptr<FrameFeed> feed;
  std::unique_ptr<Encoder> encoder;
  std::unique_ptr<Publisher> publisher;
  std::unique_ptr<StreamSender> sender;
  std::unique_ptr<FramePlayer> player;
  std::optional<Watchdog> watchdog;
  WorkerThread source_thread, sender_thread;
  std::string told;  // the refusal printed last

  Result<Done> prepare(const MemoryPlan& plan, const LcmUrl& url);
  Result<Done> start();
  Result<Done> start_threads();
  void lock_memory() const;
  void warn() const;
  void look_at_stages();
  void watch(StatusReport& report);
  void finish();
  void tell_refusals();
  StreamMoment moment() const;
  StreamCounts counts(bool ended) const;
  ExitCode verdict(const StreamCounts& counts) const;
};

Result<Done> Daemon::prepare(const MemoryPlan& plan, const LcmUrl& url) {
  if (input.link == nullptr) {
    auto link = LcmLink::open(url, false);
    if (!link) return link.error();
    input.link = std::move(*link);
  }
  auto taken = take_memory(needs, plan, {});
  if (!taken) return taken.error();
  memory = std::move(*taken);
  lock_memory();
  const FeedConfig feed_config{.repeat = options.repeat, .live = input.live != nullptr};
  feed =
      std::make_unique<FrameFeed>(*input.source, input.setup, std::move(input.first), feed_config);
  const auto loaded = feed->preload(memory.preloaded, [this] { return signals.asked(); });
  if (!loaded) return loaded.error();
  auto made = Encoder::create(needs.encoder, memory.encoder);
  if (!made) return made.error();
  encoder = std::move(*made);
  auto published = Publisher::create(needs.publisher, input.link, &memory.arena);
  if (!published) return published.error();
  publisher = std::move(*published);
  memory.arena.seal();
  return Done{};
}

// What the machine refuses is said once; the stream runs all the same.
void Daemon::warn() const {
  const StageRunner& runner = encoder->runner();
  for (const std::string& line : refusals(runner.fifo_refused(), runner.affinity_refused()))
    fmt::print(stderr, "planecastd: {}\n", line);
}

Result<Done> Daemon::start_threads() {
  const auto send = [](void* self) -> void* {
    dress_this_thread("sender");
    static_cast<Daemon*>(self)->sender->run();
    return nullptr;
  };
  const auto play = [](void* self) -> void* {
    dress_this_thread("source");
    static_cast<Daemon*>(self)->player->run();
    return nullptr;
  };
  if (sender_thread.start(send, this) == 0 && source_thread.start(play, this) == 0) return Done{};
  encoder->stop(StopMode::kDiscard);
  sender_thread.join();
  return {Status::kOutOfArena,
          "the system refuses a thread; raise the limits of processes and of memory"};
}

// Before any thread of ours starts, so that none meets a page fault; and again when all is mapped,
// where what comes later cannot be locked in advance.
void Daemon::lock_memory() const {
  if (!daemon.realtime.lock_memory) return;
  const std::string refused = lock_all_memory();
  if (!refused.empty()) fmt::print(stderr, "planecastd: {}\n", refused);
}

Result<Done> Daemon::start() {
  if (const auto started = encoder->start(); !started) return started.error();
  sender = std::make_unique<StreamSender>(
      *encoder, *publisher,
      SenderConfig{.key_every_frames = key_interval(input.rate_hz), .wait = daemon.wait});
  PlayerConfig player_config;
  player_config.wait = daemon.wait;
  if (input.live == nullptr) player_config.rate_hz = input.rate_hz;
  player = std::make_unique<FramePlayer>(*feed, *encoder, player_config);
  if (daemon.realtime.watchdog_ns() > 0)
    watchdog.emplace(encoder->runner(), daemon.realtime.watchdog_ns());
  if (const auto started = start_threads(); !started) return started.error();
  lock_memory();
  warn();
  return Done{};
}

void Daemon::look_at_stages() {
  if (!watchdog) return;
  const std::uint32_t fell = watchdog->look();
  for (std::uint32_t i = 0; fell >> i != 0; ++i) {
    if ((fell >> i & 1U) != 0)
      fmt::print(stderr, "planecastd: watchdog: stage {} is silent for more than {:g} ms\n",
                 encoder->runner().report(i).name, daemon.realtime.watchdog_ms);
  }
}

StreamMoment Daemon::moment() const {
  const StreamCounts now = counts(false);
  return {monotonic_ns(), now.sender, now.dropped(), now.failed()};
}

void Daemon::tell_refusals() {
  std::string refusal = feed->refusal();
  if (refusal.empty() && input.live != nullptr) refusal = input.live->refusal();
  if (!refusal.empty() && refusal != told) fmt::print(stderr, "planecastd: refused: {}\n", refusal);
  told = refusal;
}

void Daemon::watch(StatusReport& report) {
  StreamMoment before = moment();
  const auto line = [&] {
    const StreamMoment now = moment();
    report.print(rates_between(before, now, sender->encode_median_ns(before.sender.sent)));
    before = now;
  };
  std::int64_t line_ns = before.time_ns + kSecondNs;
  const std::int64_t poll_ns =
      watchdog ? std::clamp<std::int64_t>(watchdog->limit_ns() / 4, 1'000'000, kPollNs) : kPollNs;
  while (!player->finished() && !signals.wait(poll_ns)) {
    look_at_stages();
    if (monotonic_ns() < line_ns) continue;
    line_ns += kSecondNs;
    tell_refusals();
    line();
  }
  finish();
  tell_refusals();
  if (sender->totals().sent > before.sender.sent) line();
}

// From the source on, so that nothing is offered to a part that is gone already.
void Daemon::finish() {
  player->stop();
  if (input.live != nullptr) input.live->interrupt();
  source_thread.join();
  encoder->stop(StopMode::kDrain);
  sender_thread.join();
  (void)publisher->flush(signals.signal() == 0 ? kFlushNs : kFlushAfterSignalNs);
  publisher->stop();
}

StreamCounts Daemon::counts(bool ended) const {
  StreamCounts out;
  out.publisher = publisher->statistics();
  out.sender = sender->totals();
  out.pipeline = encoder->runner().totals();
  out.in = out.pipeline.in;
  out.gated_readings = player->out_of_range();
  if (input.live == nullptr) {
    out.refused = feed->refused();
    out.in += out.refused;
    return out;
  }
  const LcmSourceCounts source = input.live->counts();
  out.in = source.messages;
  out.refused = source.refused_malformed + feed->refused();
  // At the end those are passed over as well that still wait to be taken, or were in hand.
  out.passed_over = ended ? source.clouds - feed->refused() - out.pipeline.in : source.passed_over;
  return out;
}

ExitCode Daemon::verdict(const StreamCounts& counts) const {
  if (player->error().status != Status::kOk) return complain(player->error());
  if (!counts.balanced()) return ExitCode::kFailed;
  const bool nothing_sent = counts.publisher.frames_published > 0 && counts.out() == 0;
  if (nothing_sent && counts.publisher.publish_errors > 0) {
    return complain(
        {Status::kNetwork,
         "the kernel refused every frame; 'planecast doctor' tells what would mend it"});
  }
  const Status failure = sender->first_failure();
  if (failure == Status::kOk) return ExitCode::kDone;
  fmt::print(stderr, "planecastd: the first frame that failed did so with {}\n",
             to_string(failure));
  return failure == Status::kBoundExceeded ? ExitCode::kBoundExceeded : ExitCode::kFailed;
}

void say(const StreamInput& input, const MemoryPlan& plan, const CodecOptions& options) {
  for (const auto& notes : {input.source->notes(), input.setup.notes}) {
    for (const std::string& note : notes) fmt::print(stderr, "planecastd: {}\n", note);
  }
  const StreamConfig& stream = input.setup.encoder.stream;
  const std::string size = stream.kind == FrameKind::kPoints
                               ? fmt::format("up to {} points", stream.points.max_points)
                               : fmt::format("{}x{}", stream.camera.width, stream.camera.height);
  fmt::print(stderr, "planecastd: stream {} on {}, {}, tolerance {}, {}, {} in memory\n",
             stream.stream, options.channel, size, to_string(options.tolerance),
             input.live != nullptr ? "at the source's pace" : fmt::format("{:g} Hz", input.rate_hz),
             human_bytes(static_cast<double>(plan.arena)));
}

}  // namespace

ExitCode run_daemon(const DaemonOptions& daemon, const CodecOptions& options) {
  const auto url = options.lcm_url.empty() ? default_lcm_url() : parse_lcm_url(options.lcm_url);
  if (!url) return complain(url.error());
  if (const auto channel = check_channel(options.channel); !channel)
    return complain(channel.error());
  StopSignals signals;
  auto input = open_input(daemon, options, *url, signals);
  if (!input) return signals.signal() != 0 ? ExitCode::kDone : complain(input.error());
  Daemon self(daemon, options, signals, std::move(*input));
  set_thread_wishes(daemon.realtime);
  self.needs.encoder = self.input.setup.encoder;
  RunnerConfig& runner = self.needs.encoder.runner;
  runner.fifo_priority = daemon.realtime.fifo_priority;
  runner.first_core = daemon.realtime.first_core;
  runner.deadline_ns = daemon.realtime.watchdog_ns();
  self.needs.publisher = publisher_for(self.needs.encoder, options.channel, options.slice_bytes);
  self.needs.publisher.on_thread_start = dress_this_thread;
  self.needs.preloaded_frames = self.input.preloaded_frames;
  const auto plan = plan_memory(self.needs);
  if (!plan) return complain(plan.error());
  if (daemon.print_memory) {
    for (const std::string& line : to_lines(*plan, self.needs, resident_bytes()))
      fmt::print("{}\n", line);
    return ExitCode::kDone;
  }
  const auto fits = check_memory_fits(plan->total(), daemon.realtime.memory_limit, memory_room(),
                                      "send smaller frames, hold fewer (--preload), or see what "
                                      "takes it: --print-memory");
  if (!fits) return complain(fits.error());
  auto report = StatusReport::open(stderr, daemon.status_file);
  if (!report) return complain(report.error());
  say(self.input, *plan, options);
  if (const auto ready = self.prepare(*plan, *url); !ready)
    return signals.signal() != 0 ? ExitCode::kDone : complain(ready.error());
  if (const auto started = self.start(); !started) return complain(started.error());
  self.watch(*report);
  const StreamCounts counts = self.counts(true);
  fmt::print(stderr, "planecastd: {}\n", signals.signal() != 0 ? "stopped by a signal" : "done");
  for (const std::string& line :
       balance_lines(counts, self.encoder->runner(), self.watchdog ? &*self.watchdog : nullptr))
    fmt::print(stderr, "{}\n", line);
  return self.verdict(counts);
}

}  // namespace planecast
