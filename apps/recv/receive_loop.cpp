#include "apps/recv/receive_loop.hpp"

#include <ctime>

#include "apps/common/frame_slices.hpp"
#include "apps/common/packet_parse.hpp"
#include "transport/wake.hpp"

namespace planecast {
namespace {

constexpr std::int64_t kWaitNs = 200'000'000;
constexpr std::int32_t kMaxGap = 3000;  // beyond it the numbers began anew, as transport holds it

std::int64_t realtime_ns() noexcept {
  timespec now{};
  ::clock_gettime(CLOCK_REALTIME, &now);
  return static_cast<std::int64_t>(now.tv_sec) * 1'000'000'000 + now.tv_nsec;
}

}  // namespace

std::size_t ReceiveLoop::memory_bytes(const ReceiveConfig& config) noexcept {
  FrameTeam team;
  return config.streams * Decoder::memory_bytes({config.limits, team.work()}) +
         stack_mapping_bytes();
}

Result<std::unique_ptr<ReceiveLoop>> ReceiveLoop::create(const ReceiveConfig& config,
                                                         Subscriber& subscriber,
                                                         const ReferenceCheck* reference,
                                                         SinkQueue* sinks) {
  std::unique_ptr<ReceiveLoop> loop(new ReceiveLoop(config, subscriber, reference, sinks));
  if (loop->team_.start({.name = "unpack2"}, config.on_thread_start) != 0)
    return Error{Status::kStopped,
                 "the system refuses a thread that helps to decode; raise the "
                 "limits of processes and of memory"};
  loop->streams_.resize(config.streams);
  for (Stream& stream : loop->streams_) {
    auto decoder = Decoder::create({config.limits, loop->team_.work()});
    if (!decoder.ok()) return decoder.error();
    stream.decoder = std::move(*decoder);
  }
  return loop;
}

void ReceiveLoop::run() noexcept {
  while (!stopping_.load(std::memory_order_acquire)) {
    const FrameRef frame = subscriber_.wait(kWaitNs);
    if (frame) work_on(*frame);
    if (config_.frames != 0 && frames_passed_ >= config_.frames) break;
  }
  if (sinks_ != nullptr) sinks_->close();
  finished_.store(true, std::memory_order_release);
}

void ReceiveLoop::stop() noexcept {
  stopping_.store(true, std::memory_order_release);
  subscriber_.interrupt();
}

// The assembler keeps at most as many streams apart as there are decoders, so one is free.
ReceiveLoop::Stream& ReceiveLoop::stream_of(std::uint16_t number) noexcept {
  Stream* free = &streams_.back();
  for (Stream& stream : streams_) {
    if (stream.used && stream.number == number) return stream;
    if (!stream.used) {
      free = &stream;
      break;
    }
  }
  free->used = true;
  free->number = number;
  return *free;
}

void ReceiveLoop::work_on(const AssembledFrame& frame) noexcept {
  const std::int64_t begin_ns = monotonic_ns();
  busy_since_ns_.store(begin_ns, std::memory_order_relaxed);
  take(frame);
  busy_since_ns_.store(0, std::memory_order_relaxed);
  if (config_.deadline_ns > 0 && monotonic_ns() - begin_ns > config_.deadline_ns)
    late_.fetch_add(1, std::memory_order_relaxed);
}

void ReceiveLoop::take(const AssembledFrame& frame) noexcept {
  Stream& stream = stream_of(frame.stream);
  FrameRecord record;
  record.stream = frame.stream;
  record.session = frame.session;
  record.frame = frame.frame;
  record.slice_count = frame.slice_count;
  record.slices = frame.slices_received;
  follow_session(stream, frame);
  const std::int64_t begin_ns = monotonic_ns();
  take_key(stream, frame);
  decode(stream, frame, record);
  record.decode_ns = monotonic_ns() - begin_ns;
  record.key_age_ns = begin_ns - stream.key_ns;
  const bool readable = record.end == FrameEnd::kComplete || record.end == FrameEnd::kPartial;
  if (readable) measure_latency(stream, frame, record);
  if (reference_ != nullptr && record.end == FrameEnd::kComplete) check(stream, record);
  if (sinks_ != nullptr && readable) hand_over(stream, record);
  if (!records_.try_push(record)) records_lost_.fetch_add(1, std::memory_order_relaxed);
}

// Frames between this one and the last were lost, unless the sender is another or began anew.
void ReceiveLoop::follow_session(Stream& stream, const AssembledFrame& frame) noexcept {
  std::uint64_t passed = 1;
  if (stream.senders == 0 || stream.session != frame.session) {
    ++stream.senders;
    stream.session = frame.session;
  } else {
    const std::int32_t gap = frame_distance(stream.last_frame, frame.frame, kPacketFrameBits);
    if (gap > 0 && gap <= kMaxGap) passed = static_cast<std::uint64_t>(gap);
  }
  stream.last_frame = frame.frame;
  frames_passed_ += passed;
}

void ReceiveLoop::take_key(Stream& stream, const AssembledFrame& frame) noexcept {
  if (frame.key_serial == 0 || frame.key_serial == stream.key_serial) return;
  stream.key_serial = frame.key_serial;
  stream.key_ns = frame.ready_ns;
  stream.key_status = stream.decoder->set_key(frame.key());
}

void ReceiveLoop::decode(Stream& stream, const AssembledFrame& frame,
                         FrameRecord& record) noexcept {
  Decoder& decoder = *stream.decoder;
  const bool refused = stream.key_status != Status::kOk && stream.key_status != Status::kUnknownKey;
  record.status = refused ? stream.key_status : decoder.begin();
  if (record.status != Status::kOk) {
    record.end = refused ? FrameEnd::kRefused : FrameEnd::kNoKey;
    if (!refused) subscriber_.count_unknown_keys(frame.stream, frame.slices_received);
    return;
  }
  for (std::uint16_t i = 0; i < frame.slice_count; ++i) record.bytes += frame.slice(i).size();
  record.status = decoder.add_all(slices_of(frame));
  if (decoder.counts().unknown_key > 0)
    subscriber_.count_unknown_keys(frame.stream, decoder.counts().unknown_key);
  (void)decoder.finish();  // begin() has shown that the tables are there
  judge(stream, frame, record);
}

void ReceiveLoop::judge(const Stream& stream, const AssembledFrame& frame,
                        FrameRecord& record) noexcept {
  const DecodedCounts& counts = stream.decoder->counts();
  record.points = counts.points;
  record.surfaces = counts.surfaces;
  record.slices_refused = counts.refused;
  if (counts.slices == frame.slice_count) {
    record.end = FrameEnd::kComplete;
  } else if (counts.slices == 0 && counts.unknown_key > 0) {
    record.end = FrameEnd::kNoKey;
  } else {
    record.end = FrameEnd::kPartial;
  }
}

// Only a clock that both ends share tells how old a frame is.
void ReceiveLoop::measure_latency(Stream& stream, const AssembledFrame& frame,
                                  FrameRecord& record) noexcept {
  const StreamConfig& config = stream.decoder->config();
  const bool monotonic = config.clock == ClockDomain::kMonotonic;
  const std::int64_t now_ns = monotonic ? monotonic_ns() : realtime_ns();
  stream.last_stamp_ns = stamp_of_offset(config.epoch_ns, frame.stamp_ns, now_ns);
  const bool shared = config.boot_id != 0 && config.boot_id == config_.boot_id;
  if (shared && (monotonic || config.clock == ClockDomain::kRealtime))
    record.latency_ns = now_ns - stream.last_stamp_ns;
}

void ReceiveLoop::check(const Stream& stream, FrameRecord& record) const noexcept {
  const FrameCheck found = reference_->check(record.frame, *stream.decoder);
  record.checked = true;
  record.comparable = found.comparable;
  record.missing = found.missing;
  record.dropped = found.dropped;
  record.invented = found.invented;
  record.max_error_m = found.max_error_m;
  record.max_ratio = found.max_ratio;
}

void ReceiveLoop::hand_over(const Stream& stream, FrameRecord& record) noexcept {
  SinkFrame who;
  who.stream = record.stream;
  who.frame = record.frame;
  who.sender = stream.senders;
  who.stamp_ns = stream.last_stamp_ns;
  who.complete = record.end == FrameEnd::kComplete;
  record.sink_dropped = !sinks_->offer(*stream.decoder, who);
}

}  // namespace planecast
