#include "apps/recv/receiver.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <thread>
#include <utility>

#include "apps/common/boot_id.hpp"
#include "apps/common/live_line.hpp"
#include "apps/common/memory_fit.hpp"
#include "apps/common/realtime.hpp"
#include "apps/common/reference_check.hpp"
#include "apps/common/stop_signals.hpp"
#include "apps/recv/frame_file.hpp"
#include "apps/recv/receive_loop.hpp"
#include "apps/recv/receive_report.hpp"
#include "apps/recv/receive_totals.hpp"
#include "apps/recv/result_picture.hpp"
#include "apps/recv/sink_queue.hpp"
#include "apps/recv/sink_writer.hpp"
#include "apps/recv/status_file.hpp"
#include "core/pipeline/worker_thread.hpp"
#include "transport/lcm_url.hpp"
#include "transport/subscriber.hpp"
#include "transport/wake.hpp"

namespace planecast {
namespace {

constexpr std::int64_t kPollNs = 20'000'000;
constexpr double kSecond = 1e-9;
constexpr std::uint32_t kSinkSlots = 5;  // one of them keeps the last complete frame

enum class EndedBy : std::uint8_t { kFrames, kSignal, kTimeout };

ExitCode complain(const Error& error) {
  fmt::print(stderr, "planecast-recv: {}\n", error.message);
  return exit_code(error.status);
}

// Members in the order in which they depend on each other.
struct Receiver {
  Receiver(const RecvOptions& given, const CodecOptions& shared, StatusFile file)
      : options(given), codec(shared), status(std::move(file)) {}

  const RecvOptions& options;
  const CodecOptions& codec;
  StatusFile status;
  std::unique_ptr<ReferenceCheck> reference;
  std::shared_ptr<LcmLink> link;
  std::unique_ptr<Subscriber> subscriber;
  std::unique_ptr<SinkQueue> queue;
  std::unique_ptr<SinkWriter> writer;
  std::unique_ptr<ReceiveLoop> loop;
  WorkerThread receive_thread;
  std::thread sink_thread;
  ReceiveTotals totals;
  std::uint64_t refusals_told = 0;
  std::int64_t heard_ns = 0;
  bool warned = false;
  bool silent_told = false;
  std::uint64_t silences = 0;

  Result<Done> prepare(const LcmUrl& url);
  Result<Done> load_reference();
  Result<Done> start();
  Result<Done> check_memory(std::size_t bytes) const;
  void warn();
  void lock_memory() const;
  void look_at_loop();
  EndedBy watch(StopSignals& signals);
  void finish();
  Result<Done> write_results();
  ExitCode verdict(EndedBy ended, const Result<Done>& written) const;

  void collect();
  void report_second(LiveLine& live, double at_s, double seconds);
  void tell(LiveLine& live);
};

Result<Done> Receiver::load_reference() {
  if (options.reference.empty()) return Done{};
  fmt::print(stderr, "planecast-recv: loading the reference {}\n", options.reference);
  auto loaded = ReferenceCheck::load(options.reference, codec);
  if (!loaded.ok()) return loaded.error();
  reference = std::make_unique<ReferenceCheck>(std::move(*loaded));
  return Done{};
}

Result<Done> Receiver::prepare(const LcmUrl& url) {
  if (!options.out_folder.empty()) {
    std::error_code failed;
    std::filesystem::create_directories(options.out_folder, failed);
    if (failed)
      return Error{Status::kWriteFailed, "--out: " + options.out_folder + ": " + failed.message()};
  }
  auto opened = LcmLink::open(url, true);
  if (!opened) return opened.error();
  link = std::move(*opened);
  const SubscriberConfig config = subscriber_for(options, codec);
  FrameLimits limits{static_cast<std::uint16_t>(options.max_size.width),
                     static_cast<std::uint16_t>(options.max_size.height)};
  // What comes is not known yet: lists are received too, as long as an image would be.
  limits.max_points = codec.max_points.value_or(limits.pixels());
  const std::uint32_t sink_points = std::max(limits.pixels(), limits.max_points);
  const ReceiveConfig receive{
      options.streams,  limits, options.frames, boot_id_hash(), options.realtime.watchdog_ns(),
      dress_this_thread};
  const std::size_t bytes =
      Subscriber::memory_bytes(config) + ReceiveLoop::memory_bytes(receive) +
      (options.has_sinks() ? SinkQueue::memory_bytes(kSinkSlots, sink_points) : 0);
  if (const auto fits = check_memory(bytes); !fits) return fits.error();
  lock_memory();
  auto subscribed = Subscriber::create(config, link);
  if (!subscribed) return subscribed.error();
  subscriber = std::move(*subscribed);
  if (options.has_sinks()) {
    auto made = SinkQueue::create(kSinkSlots, sink_points);
    if (!made.ok()) return made.error();
    queue = std::move(*made);
    writer = std::make_unique<SinkWriter>(options, *queue, link);
  }
  auto made = ReceiveLoop::create(receive, *subscriber, reference.get(), queue.get());
  if (!made.ok()) return made.error();
  loop = std::move(*made);
  fmt::print(stderr, "planecast-recv: listening to {} on {}; {} taken for {} streams up to {}x{}\n",
             codec.channel, to_string(url), human_bytes(static_cast<double>(bytes)),
             options.streams, options.max_size.width, options.max_size.height);
  return Done{};
}

Result<Done> Receiver::check_memory(std::size_t bytes) const {
  constexpr std::size_t kThreads = 2;  // subscriber and receive
  return check_memory_fits(bytes + kThreads * stack_mapping_bytes(), options.realtime.memory_limit,
                           memory_room(),
                           "receive smaller frames (--max-size) or fewer streams (--streams)");
}

// As in planecastd: before the threads, and again when all is mapped.
void Receiver::lock_memory() const {
  if (!options.realtime.lock_memory) return;
  const std::string refused = lock_all_memory();
  if (!refused.empty()) fmt::print(stderr, "planecast-recv: {}\n", refused);
}

// What the machine refuses is said once; the receiver runs all the same.
Result<Done> Receiver::start() {
  const auto receive = [](void* self) -> void* {
    dress_this_thread("receive");
    static_cast<Receiver*>(self)->loop->run();
    return nullptr;
  };
  if (receive_thread.start(receive, this) != 0)
    return {Status::kOutOfArena,
            "the system refuses a thread; raise the limits of processes and of memory"};
  if (writer != nullptr) sink_thread = std::thread([this] { writer->run(); });
  lock_memory();
  status.write({"ready=1"});
  return Done{};
}

// Once, when the threads have had the time to ask.
void Receiver::warn() {
  if (std::exchange(warned, true)) return;
  for (const std::string& line : refusals(false, false))
    fmt::print(stderr, "planecast-recv: {}\n", line);
}

void Receiver::look_at_loop() {
  const std::int64_t limit_ns = options.realtime.watchdog_ns();
  if (limit_ns <= 0) return;
  const bool silent = loop->busy_ns(monotonic_ns()) > limit_ns;
  if (silent && !silent_told) {
    ++silences;
    fmt::print(stderr, "planecast-recv: watchdog: decoding is silent for more than {:g} ms\n",
               options.realtime.watchdog_ms);
  }
  silent_told = silent;
}

void Receiver::collect() {
  FrameRecord record;
  while (loop->records().try_pop(record)) {
    totals.add(record);
    heard_ns = monotonic_ns();
    if (record.end == FrameEnd::kRefused && refusals_told++ == 0) {
      fmt::print(stderr, "planecast-recv: stream {}: its key packet is refused: {}{}\n",
                 record.stream, to_string(record.status),
                 record.status == Status::kFrameTooLarge
                     ? "; its frames are larger than --max-size, or for lists of points than "
                       "--max-points; name a larger one"
                     : "");
    }
  }
}

void Receiver::tell(LiveLine& live) {
  if (writer == nullptr) return;
  for (const std::string& complaint : writer->take_complaints()) {
    live.finish();
    fmt::print(stderr, "planecast-recv: {}\n", complaint);
  }
}

void Receiver::report_second(LiveLine& live, double at_s, double seconds) {
  const ReceiverStatistics statistics = subscriber->statistics();
  live.print(live_line(totals, seconds, statistics, options.stats));
  status.write(status_lines(totals, at_s, seconds, statistics));
  tell(live);
  totals.next_second();
}

EndedBy Receiver::watch(StopSignals& signals) {
  LiveLine live(stderr);
  const std::int64_t start_ns = monotonic_ns();
  std::int64_t line_ns = start_ns;
  heard_ns = start_ns;
  EndedBy ended = EndedBy::kFrames;
  for (;;) {
    const bool last = loop->finished();
    const bool signalled = !last && signals.wait(kPollNs);
    warn();
    collect();
    look_at_loop();
    const std::int64_t now_ns = monotonic_ns();
    const double silent_s = static_cast<double>(now_ns - heard_ns) * kSecond;
    const bool silent = options.timeout_s && silent_s > *options.timeout_s;
    const double seconds = static_cast<double>(now_ns - line_ns) * kSecond;
    const bool over = last || signalled || silent;
    if (seconds >= 1.0 || (over && totals.records() > 0)) {
      report_second(live, static_cast<double>(now_ns - start_ns) * kSecond, seconds);
      line_ns = now_ns;
    }
    if (signalled) ended = EndedBy::kSignal;
    if (silent && !last && !signalled) ended = EndedBy::kTimeout;
    if (over) break;
  }
  return ended;
}

void Receiver::finish() {
  loop->stop();
  receive_thread.join();
  if (sink_thread.joinable()) sink_thread.join();
  subscriber->stop();
  collect();
  const ReceiverStatistics statistics = subscriber->statistics();
  status.write(final_lines(totals, statistics));
  std::FILE* out = options.stats ? stdout : stderr;
  for (const std::string& line : table(totals, statistics, options.stats))
    fmt::print(out, "{}\n", line);
  if (loop->records_lost() > 0)
    fmt::print(stderr, "planecast-recv: {} frames are not in these sums\n", loop->records_lost());
  if (options.realtime.watchdog_ns() > 0)
    fmt::print(out, "  watchdog, {:g} ms: late {}; silent {}\n", options.realtime.watchdog_ms,
               loop->late(), silences);
  if (writer == nullptr) return;
  for (const std::string& complaint : writer->take_complaints())
    fmt::print(stderr, "planecast-recv: {}\n", complaint);
  if (!options.out_folder.empty())
    fmt::print(stderr, "planecast-recv: {} files written to {}\n", writer->files_written(),
               options.out_folder);
  if (options.publish_name)
    fmt::print(stderr, "planecast-recv: {} plain clouds published\n", writer->clouds_published());
}

Result<Done> Receiver::write_results() {
  if (options.last_file.empty() && options.picture_file.empty()) return Done{};
  const SinkFrame* frame = writer->last_complete();
  if (frame == nullptr)
    return Error{Status::kNotFound, "no complete frame came: --last and --picture wrote nothing"};
  if (!options.last_file.empty()) {
    const auto format = format_of(options.last_file);  // checked at start
    if (const auto done = write_frame(*frame, *format, options.last_file); !done.ok())
      return done.error();
    fmt::print(stderr, "planecast-recv: wrote frame {} to {}\n", frame->frame, options.last_file);
  }
  if (options.picture_file.empty()) return Done{};
  const auto done = write_result_picture(*frame, reference.get(), options.picture_file);
  if (!done.ok()) return done.error();
  fmt::print(stderr, "planecast-recv: drew frame {} in {}\n", frame->frame, options.picture_file);
  return Done{};
}

ExitCode Receiver::verdict(EndedBy ended, const Result<Done>& written) const {
  const ReceiverStatistics statistics = subscriber->statistics();
  if (ended == EndedBy::kTimeout) {
    const std::uint64_t messages = statistics.link.messages - statistics.link.greetings;
    fmt::print(stderr,
               "planecast-recv: no frame for {:g} s{}; is planecastd running on channel {}? "
               "'planecast doctor' checks the network\n",
               *options.timeout_s,
               messages > 0 && totals.records() == 0
                   ? fmt::format(", though {} messages came", messages)
                   : "",
               codec.channel);
  }
  if (!written.ok()) fmt::print(stderr, "planecast-recv: {}\n", written.error().message);
  if (totals.bound_exceeded()) {
    fmt::print(stderr, "planecast-recv: a bound is exceeded\n");
    return ExitCode::kBoundExceeded;
  }
  if (reference != nullptr && totals.frame_missing(statistics)) {
    fmt::print(stderr, "planecast-recv: not every frame arrived whole\n");
    return ExitCode::kFailed;
  }
  const bool failed = ended == EndedBy::kTimeout || !written.ok() ||
                      (writer != nullptr && writer->failures() > 0) || refusals_told > 0;
  return failed ? ExitCode::kFailed : ExitCode::kDone;
}

}  // namespace

ExitCode run_receiver(const RecvOptions& options, const CodecOptions& codec) {
  const auto url = codec.lcm_url.empty() ? default_lcm_url() : parse_lcm_url(codec.lcm_url);
  if (!url) return complain(url.error());
  if (const auto channel = check_channel(codec.channel); !channel) return complain(channel.error());
  auto status = StatusFile::open(options.status_file);
  if (!status.ok()) return complain(status.error());
  set_thread_wishes(options.realtime);
  Receiver self(options, codec, std::move(*status));
  if (const auto loaded = self.load_reference(); !loaded) return complain(loaded.error());
  StopSignals signals;  // from here on; a signal while loading just ends the process
  if (const auto ready = self.prepare(*url); !ready) return complain(ready.error());
  if (signals.asked()) return ExitCode::kDone;
  if (const auto started = self.start(); !started) return complain(started.error());
  const EndedBy ended = self.watch(signals);
  self.finish();
  return self.verdict(ended, self.write_results());
}

}  // namespace planecast
