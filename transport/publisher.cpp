#include "transport/publisher.hpp"

#include <sys/prctl.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <new>
#include <vector>

#include "transport/overwrite_ring.hpp"
#include "transport/service_thread.hpp"
#include "transport/wake.hpp"

namespace planecast {
namespace {

constexpr std::int64_t kIdleWaitNs = 100'000'000;
constexpr std::int64_t kFlushPollNs = 500'000;

/// Written by one thread, read by any.
class Counter {
 public:
  void add(std::uint64_t amount) noexcept {
    value_.store(value_.load(std::memory_order_relaxed) + amount, std::memory_order_release);
  }
  std::uint64_t get() const noexcept { return value_.load(std::memory_order_acquire); }

 private:
  std::atomic<std::uint64_t> value_{0};
};

void sleep_until(std::int64_t deadline_ns) noexcept {
  const timespec deadline = to_timespec(deadline_ns);
  while (::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &deadline, nullptr) == EINTR) {
  }
}

std::string config_mistake(const PublisherConfig& config) {
  const std::size_t largest = std::min(max_datagram_message_bytes(config.channel),
                                       kEnvelopeOverheadBytes + kMaxPacketBytes);
  if (config.frames < 3 || config.frames > 64) return "publisher frames must be 3 to 64";
  if (config.max_packets < 1 || config.max_packets > 65'536)
    return "publisher max_packets must be 1 to 65536";
  if (config.message_bytes <= kEnvelopeOverheadBytes || config.message_bytes > largest)
    return "the LCM message size must be 11 to " + std::to_string(largest) + " bytes";
  if (config.max_frame_bytes < config.message_bytes || config.max_frame_bytes > (1U << 30U))
    return "publisher max_frame_bytes must hold at least one message and at most 1 GiB";
  if (config.burst_packets < 1) return "publisher burst_packets must be at least 1";
  if (config.pace_ns > 100'000'000) return "publisher pace_ns must be at most 100 ms";
  return {};
}

}  // namespace

std::span<std::uint8_t> FrameBuffer::space() noexcept {
  if (packets_ == max_packets_ || capacity_ - used_ <= kEnvelopeOverheadBytes) return {};
  const std::uint32_t start = used_ + kEnvelopeOverheadBytes;
  return {memory_ + start, std::min(capacity_ - start, max_packet_bytes_)};
}

Status FrameBuffer::commit(std::size_t packet_bytes, bool key) noexcept {
  if (packet_bytes == 0 || packet_bytes > space().size()) return Status::kWrongSize;
  write_envelope_header(packet_bytes, std::span<std::uint8_t, kEnvelopeOverheadBytes>(
                                          memory_ + used_, kEnvelopeOverheadBytes));
  const auto bytes = static_cast<std::uint32_t>(kEnvelopeOverheadBytes + packet_bytes);
  table_[packets_++] = {used_, bytes};
  used_ += bytes;
  holds_key_ = holds_key_ || key;
  return Status::kOk;
}

Status FrameBuffer::append(std::span<const std::uint8_t> packet, bool key) noexcept {
  if (packet.empty() || packet.size() > max_packet_bytes_) return Status::kWrongSize;
  const std::span<std::uint8_t> room = space();
  if (packet.size() > room.size()) return Status::kTooLarge;
  std::memcpy(room.data(), packet.data(), packet.size());
  return commit(packet.size(), key);
}

struct Publisher::Impl {
  PublisherConfig config;
  std::shared_ptr<LcmLink> link;
  Arena own_arena;
  std::span<FrameBuffer> buffers;
  OverwriteRing ring;
  Wake wake;
  std::atomic<bool> stopping{false};
  ServiceThread thread;

  // The pipeline thread's.
  FrameBuffer* claimed = nullptr;
  bool key_lost = false;
  Counter published, dropped_oldest, abandoned;
  // The sending thread's.
  alignas(64) Counter sent;
  Counter failed, dropped_at_stop, packets, bytes, errors;

  void lay_out(Arena& arena) noexcept;
  void run() noexcept;
  void send(const FrameBuffer& frame) noexcept;
  std::uint64_t finished() const noexcept {
    return sent.get() + failed.get() + dropped_oldest.get() + dropped_at_stop.get();
  }
};

void Publisher::Impl::lay_out(Arena& arena) noexcept {
  ring.init(arena.take<OverwriteRing::Word>(config.frames));
  buffers = arena.take<FrameBuffer>(config.frames);
  for (std::uint32_t i = 0; i < config.frames; ++i) {
    const auto table = arena.take<FrameBuffer::Packet>(config.max_packets);
    const auto memory = arena.take<std::uint8_t>(config.max_frame_bytes);
    if (buffers.empty()) continue;
    FrameBuffer& buffer = buffers[i];
    buffer.table_ = table.data();
    buffer.memory_ = memory.data();
    buffer.capacity_ = config.max_frame_bytes;
    buffer.max_packets_ = config.max_packets;
    buffer.max_packet_bytes_ = static_cast<std::uint32_t>(max_packet_bytes(config.message_bytes));
  }
}

void Publisher::Impl::send(const FrameBuffer& frame) noexcept {
  const bool paced = config.pace_ns > 0 && frame.packets_ > config.pace_above_packets;
  const auto burst_ns = static_cast<std::int64_t>(config.burst_packets) * config.pace_ns;
  std::int64_t next_burst_ns = 0;
  bool all_sent = true;
  for (std::uint32_t i = 0; i < frame.packets_; ++i) {
    if (paced && i % config.burst_packets == 0) {
      // Counted from when the burst really starts: after a late wake-up nothing is caught up, a
      // receiver with small buffers would lose it.
      if (i > 0) sleep_until(next_burst_ns);
      next_burst_ns = monotonic_ns() + burst_ns;
      if (stopping.load(std::memory_order_relaxed)) {
        all_sent = false;
        break;
      }
    }
    const FrameBuffer::Packet& packet = frame.table_[i];
    const Status status =
        link->publish(config.channel.c_str(), {frame.memory_ + packet.offset, packet.bytes});
    if (status == Status::kOk) {
      packets.add(1);
      bytes.add(packet.bytes);
    } else {
      errors.add(1);
      all_sent = false;
    }
  }
  (all_sent ? sent : failed).add(1);
}

void Publisher::Impl::run() noexcept {
  // The default slack of 50 us would double the pace.
  ::prctl(PR_SET_TIMERSLACK, 1000UL, 0UL, 0UL, 0UL);
  for (;;) {
    const int slot = ring.take();
    const bool stop = stopping.load(std::memory_order_acquire);
    if (slot == OverwriteRing::kNone) {
      if (stop) return;
      (void)wake.wait_until(monotonic_ns() + kIdleWaitNs);
      continue;
    }
    if (stop) {
      dropped_at_stop.add(1);
    } else {
      send(buffers[slot]);
    }
    ring.release(slot);
  }
}

Publisher::Publisher(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

Publisher::~Publisher() {
  stop();
}

std::size_t Publisher::memory_bytes(const PublisherConfig& config) noexcept {
  Impl measured;
  measured.config = config;
  Arena arena = Arena::measuring();
  measured.lay_out(arena);
  return arena.bytes_needed();
}

Result<std::unique_ptr<Publisher>> Publisher::create(const PublisherConfig& config,
                                                     std::shared_ptr<LcmLink> link, Arena* arena) {
  const Result<Done> channel = check_channel(config.channel);
  if (!channel) return channel.error();
  std::string mistake = config_mistake(config);
  if (!mistake.empty()) return {Status::kBadConfig, std::move(mistake)};
  auto impl = std::make_unique<Impl>();
  impl->config = config;
  impl->link = std::move(link);
  if (arena == nullptr) {
    Result<Arena> mapped = Arena::map(memory_bytes(config));
    if (!mapped) return mapped.error();
    impl->own_arena = std::move(*mapped);
    arena = &impl->own_arena;
  }
  impl->lay_out(*arena);
  if (arena->failed())
    return {Status::kOutOfArena, "the publisher needs " + std::to_string(memory_bytes(config)) +
                                     " bytes, more than the arena has left"};
  std::unique_ptr<Publisher> publisher(new Publisher(std::move(impl)));
  Impl* raw = publisher->impl_.get();
  const auto entry = [](void* self) { static_cast<Impl*>(self)->run(); };
  const auto started = raw->thread.start("publisher", config.on_thread_start, entry, raw);
  if (!started) return started.error();
  return publisher;
}

FrameBuffer* Publisher::claim() noexcept {
  Impl& impl = *impl_;
  if (impl.claimed != nullptr || impl.stopping.load(std::memory_order_relaxed)) return nullptr;
  // With three buffers or more one is free or queued; between two looks the sender may have moved
  // the only queued one on, and then freed another.
  int slot = impl.ring.claim();
  while (slot == OverwriteRing::kNone) {
    slot = impl.ring.claim_oldest();
    if (slot != OverwriteRing::kNone) {
      impl.dropped_oldest.add(1);
      impl.key_lost = impl.key_lost || impl.buffers[slot].holds_key_;
      break;
    }
    slot = impl.ring.claim();
  }
  FrameBuffer& frame = impl.buffers[slot];
  frame.used_ = 0;
  frame.packets_ = 0;
  frame.holds_key_ = false;
  frame.key_wanted_ = impl.key_lost;
  impl.claimed = &frame;
  return &frame;
}

Status Publisher::publish(FrameBuffer* frame) noexcept {
  Impl& impl = *impl_;
  if (frame == nullptr || frame != impl.claimed) return Status::kBadConfig;
  if (frame->packets_ == 0) {
    abandon(frame);
    return Status::kWrongSize;
  }
  if (frame->holds_key_) impl.key_lost = false;
  impl.claimed = nullptr;
  impl.published.add(1);
  impl.ring.publish(static_cast<int>(frame - impl.buffers.data()));
  impl.wake.notify();
  return Status::kOk;
}

void Publisher::abandon(FrameBuffer* frame) noexcept {
  Impl& impl = *impl_;
  if (frame == nullptr || frame != impl.claimed) return;
  impl.claimed = nullptr;
  impl.abandoned.add(1);
  impl.ring.abandon(static_cast<int>(frame - impl.buffers.data()));
}

bool Publisher::flush(std::int64_t timeout_ns) const noexcept {
  const std::int64_t limit_ns = monotonic_ns() + timeout_ns;
  while (impl_->finished() < impl_->published.get()) {
    const std::int64_t now_ns = monotonic_ns();
    if (now_ns >= limit_ns) return false;
    sleep_until(std::min(limit_ns, now_ns + kFlushPollNs));
  }
  return true;
}

void Publisher::stop() noexcept {
  impl_->stopping.store(true, std::memory_order_release);
  impl_->wake.notify();
  impl_->thread.join();
}

PublisherStatistics Publisher::statistics() const noexcept {
  const Impl& impl = *impl_;
  PublisherStatistics out;
  // Ends before beginnings: a frame finished in between must not make the rest negative.
  out.frames_sent = impl.sent.get();
  out.frames_failed = impl.failed.get();
  out.frames_dropped_oldest = impl.dropped_oldest.get();
  out.frames_dropped_at_stop = impl.dropped_at_stop.get();
  out.frames_published = impl.published.get();
  out.frames_abandoned = impl.abandoned.get();
  out.frames_queued = out.frames_published - out.frames_sent - out.frames_failed -
                      out.frames_dropped_oldest - out.frames_dropped_at_stop;
  out.packets = impl.packets.get();
  out.bytes = impl.bytes.get();
  out.publish_errors = impl.errors.get();
  return out;
}

}  // namespace planecast
