#include "transport/stream_assembler.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <ctime>

namespace planecast {
namespace {

// RFC 3550's MAX_DROPOUT: a jump beyond it is a new numbering, not loss.
constexpr std::int32_t kMaxJump = 3000;
constexpr double kJitterGain = 1.0 / 16.0;
constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();

std::int64_t realtime_ns() noexcept {
  timespec now{};
  ::clock_gettime(CLOCK_REALTIME, &now);
  return static_cast<std::int64_t>(now.tv_sec) * 1'000'000'000 + now.tv_nsec;
}

}  // namespace

void StreamAssembler::lay_out(const AssemblerConfig& config, Arena& arena) noexcept {
  config_ = config;
  const std::size_t slots =
      std::size_t{config.frames_in_assembly} + config.output_frames + config.held_frames;
  ring_.init(arena.take<OverwriteRing::Word>(slots));
  slots_ = arena.take<AssembledFrame>(slots);
  for (std::size_t i = 0; i < slots; ++i) {
    const auto table = arena.take<AssembledFrame::Slice>(config.max_slices);
    const auto key = arena.take<std::uint8_t>(config.max_key_bytes);
    const auto bytes = arena.take<std::uint8_t>(config.max_frame_bytes);
    if (slots_.empty()) continue;
    slots_[i].table_ = table.data();
    slots_[i].key_ = key.data();
    slots_[i].bytes_ = bytes.data();
  }
  // Enough that the key of the oldest frame in assembly survives one for every frame after it.
  key_slots_ = config.frames_in_assembly + 1U;
  keys_ = arena.take<Key>(key_slots_);
  for (std::size_t i = 0; i < key_slots_; ++i) {
    const auto data = arena.take<std::uint8_t>(config.max_key_bytes);
    if (!keys_.empty()) keys_[i].data = data.data();
  }
}

bool StreamAssembler::push(std::span<const std::uint8_t> packet, const PacketInfo& info,
                           std::int64_t now_ns) noexcept {
  const std::uint64_t before = handed_on_;
  ++(info.key ? statistics_.keys_received : statistics_.slices_received);
  if (!enter_session(info, now_ns)) {
    ++(info.key ? statistics_.keys_ignored : statistics_.slices_old_session);
  } else if (info.key) {
    take_key(packet, info, now_ns);
  } else {
    take_slice(packet, info, now_ns);
  }
  finish_call();
  return handed_on_ != before;
}

bool StreamAssembler::poll(std::int64_t now_ns) noexcept {
  if (now_ns < next_deadline_ns_) return false;
  const std::uint64_t before = handed_on_;
  for (std::size_t i = 0; i < pending_count_;) {
    const AssembledFrame& frame = slots_[pending_[i]];
    if (frame.first_ns + config_.deadline_ns > now_ns) {
      ++i;
      continue;
    }
    hand_on_through(frame.frame, now_ns);
    i = 0;
  }
  finish_call();
  return handed_on_ != before;
}

// A packet of another session means that the sender was restarted: follow it at once. Only a
// session that was replaced before must wait until its successor has fallen silent, or else its
// last packets in flight would throw the new session out again.
bool StreamAssembler::enter_session(const PacketInfo& info, std::int64_t now_ns) noexcept {
  if (!started_) {
    start_session(info);
  } else if (info.session != statistics_.session) {
    if (retired(info.session) && now_ns - last_packet_ns_ < config_.session_timeout_ns)
      return false;
    retired_[retired_count_++ % retired_.size()] = statistics_.session;
    ++statistics_.session_changes;
    while (pending_count_ > 0) {
      const int slot = pending_[0];
      ++statistics_.frames_discarded;
      statistics_.slices_discarded += slots_[slot].slices_received;
      remove_pending(slot);
      ring_.abandon(slot);
    }
    start_session(info);
  }
  last_packet_ns_ = now_ns;
  return true;
}

bool StreamAssembler::retired(std::uint32_t session) const noexcept {
  const std::size_t known = std::min(retired_count_, retired_.size());
  return std::find(retired_.begin(), retired_.begin() + static_cast<std::ptrdiff_t>(known),
                   session) != retired_.begin() + static_cast<std::ptrdiff_t>(known);
}

void StreamAssembler::start_session(const PacketInfo& info) noexcept {
  started_ = true;
  statistics_.session = info.session;
  has_transit_ = false;
  restart_numbers(info.frame);
}

// Joining at frame n: reordered packets of the frames that may still be in assembly beside it are
// welcome, and what went before it was never ours to lose.
void StreamAssembler::restart_numbers(std::uint32_t frame) noexcept {
  newest_ = frame;
  last_closed_ = frame - config_.frames_in_assembly;
  counts_lost_ = false;
  closed_.fill({});
  first_key_serial_ = key_serial_ + 1;
}

StreamAssembler::Place StreamAssembler::place(std::uint32_t frame, std::int64_t now_ns) noexcept {
  const std::int32_t ahead = distance(last_closed_, frame);
  if (ahead > kMaxJump || ahead < -kMaxJump) {
    hand_on_through(newest_, now_ns);
    ++statistics_.resyncs;
    restart_numbers(frame);
    return Place::kCurrent;
  }
  if (ahead <= 0) return Place::kOld;
  if (distance(newest_, frame) > 0) newest_ = frame;
  const auto closes = static_cast<std::uint32_t>(config_.frames_in_assembly);
  const std::uint32_t too_old = newest_ - closes;
  hand_on_through(too_old, now_ns);
  return distance(frame, too_old) >= 0 ? Place::kOld : Place::kCurrent;
}

void StreamAssembler::take_key(std::span<const std::uint8_t> packet, const PacketInfo& info,
                               std::int64_t now_ns) noexcept {
  (void)place(info.frame, now_ns);
  const bool have_key = key_serial_ >= first_key_serial_;
  const Key& last = keys_[key_serial_ % key_slots_];
  if (packet.size() > config_.max_key_bytes ||
      (have_key && distance(last.frame, info.frame) <= 0)) {
    ++statistics_.keys_ignored;
    return;
  }
  Key& key = keys_[++key_serial_ % key_slots_];
  key.frame = info.frame;
  key.bytes = static_cast<std::uint32_t>(packet.size());
  std::memcpy(key.data, packet.data(), packet.size());
}

void StreamAssembler::take_slice(std::span<const std::uint8_t> packet, const PacketInfo& info,
                                 std::int64_t now_ns) noexcept {
  if (info.slice_count > config_.max_slices || packet.size() > config_.max_frame_bytes) {
    ++statistics_.slices_too_large;
    return;
  }
  if (place(info.frame, now_ns) == Place::kOld) {
    count_late(info);
    return;
  }
  AssembledFrame* frame = frame_of(info, now_ns);
  if (frame == nullptr || !store(*frame, packet, info)) return;
  if (frame->complete()) hand_on_through(info.frame, now_ns);
}

void StreamAssembler::count_late(const PacketInfo& info) noexcept {
  for (const Closed& closed : closed_) {
    if (closed.known && closed.frame == info.frame && closed.complete) {
      ++statistics_.slices_duplicate;
      return;
    }
  }
  ++statistics_.slices_late;
}

AssembledFrame* StreamAssembler::frame_of(const PacketInfo& info, std::int64_t now_ns) noexcept {
  for (std::size_t i = 0; i < pending_count_; ++i)
    if (slots_[pending_[i]].frame == info.frame) return &slots_[pending_[i]];
  int slot = ring_.claim();
  if (slot == OverwriteRing::kNone) {
    slot = ring_.claim_oldest();
    if (slot == OverwriteRing::kNone) {
      ++statistics_.slices_no_slot;
      return nullptr;
    }
    ++statistics_.frames_skipped;
  }
  AssembledFrame& frame = slots_[slot];
  frame.stream = info.stream;
  frame.session = info.session;
  frame.frame = info.frame;
  frame.stamp_ns = info.stamp_ns;
  frame.first_ns = now_ns;
  frame.slice_count = info.slice_count;
  frame.slices_received = 0;
  frame.used_ = 0;
  frame.highest_slice_ = 0;
  std::memset(frame.table_, 0, info.slice_count * sizeof(AssembledFrame::Slice));
  pending_[pending_count_++] = slot;
  if (info.frame == newest_) measure_jitter(info, now_ns);
  return &frame;
}

bool StreamAssembler::store(AssembledFrame& frame, std::span<const std::uint8_t> packet,
                            const PacketInfo& info) noexcept {
  if (info.slice_count != frame.slice_count) {
    ++statistics_.slices_inconsistent;
    return false;
  }
  AssembledFrame::Slice& slice = frame.table_[info.slice];
  if (slice.bytes != 0) {
    ++statistics_.slices_duplicate;
    return false;
  }
  if (packet.size() > config_.max_frame_bytes - frame.used_) {
    ++statistics_.slices_too_large;
    return false;
  }
  if (info.slice < frame.highest_slice_ || info.frame != newest_) ++statistics_.slices_reordered;
  frame.highest_slice_ = std::max(frame.highest_slice_, info.slice);
  slice.offset = frame.used_;
  slice.bytes = static_cast<std::uint32_t>(packet.size());
  std::memcpy(frame.bytes_ + frame.used_, packet.data(), packet.size());
  frame.used_ += slice.bytes;
  ++frame.slices_received;
  return true;
}

// RFC 3550 section 6.4.1; the clocks' offset cancels.
void StreamAssembler::measure_jitter(const PacketInfo& info, std::int64_t now_ns) noexcept {
  if (has_transit_ && info.stamp_ns == last_stamp_ns_) return;  // a source without stamps
  const std::int64_t transit_ns = static_cast<std::int64_t>(
      static_cast<std::uint64_t>(now_ns) - static_cast<std::uint64_t>(info.stamp_ns));
  if (has_transit_) {
    const double difference =
        std::abs(static_cast<double>(transit_ns) - static_cast<double>(last_transit_ns_));
    statistics_.jitter_ns += (difference - statistics_.jitter_ns) * kJitterGain;
  }
  has_transit_ = true;
  last_transit_ns_ = transit_ns;
  last_stamp_ns_ = info.stamp_ns;
}

int StreamAssembler::oldest_pending() const noexcept {
  int oldest = pending_[0];
  for (std::size_t i = 1; i < pending_count_; ++i)
    if (distance(slots_[oldest].frame, slots_[pending_[i]].frame) < 0) oldest = pending_[i];
  return oldest;
}

void StreamAssembler::remove_pending(int slot) noexcept {
  std::size_t i = 0;
  while (pending_[i] != slot) ++i;
  pending_[i] = pending_[--pending_count_];
}

/// Hands on every frame in assembly up to and including `frame`, oldest first.
void StreamAssembler::hand_on_through(std::uint32_t frame, std::int64_t now_ns) noexcept {
  while (pending_count_ > 0) {
    const int slot = oldest_pending();
    if (distance(slots_[slot].frame, frame) < 0) return;
    hand_on(slot, now_ns);
  }
}

void StreamAssembler::hand_on(int slot, std::int64_t now_ns) noexcept {
  AssembledFrame& frame = slots_[slot];
  remove_pending(slot);
  frame.ready_ns = now_ns;
  attach_key(frame);
  ++(frame.complete() ? statistics_.frames_complete : statistics_.frames_partial);
  statistics_.slices_delivered += frame.slices_received;
  statistics_.slices_lost += static_cast<std::uint64_t>(frame.slice_count - frame.slices_received);
  if (counts_lost_)
    statistics_.frames_lost += static_cast<std::uint64_t>(distance(last_closed_, frame.frame) - 1);
  counts_lost_ = true;
  last_closed_ = frame.frame;
  closed_[closed_next_++ % closed_.size()] = {frame.frame, true, frame.complete()};
  statistics_.assembly.add(now_ns - frame.first_ns);
  if (config_.stamp_clock != StampClock::kUnknown) {
    const bool monotonic = config_.stamp_clock == StampClock::kMonotonic;
    statistics_.capture.add((monotonic ? now_ns : realtime_ns()) - frame.stamp_ns);
  }
  for (int old = ring_.claim_oldest(config_.output_frames); old != OverwriteRing::kNone;
       old = ring_.claim_oldest(config_.output_frames)) {
    ++statistics_.frames_skipped;
    ring_.abandon(old);
  }
  ring_.publish(slot);
  ++handed_on_;
}

void StreamAssembler::attach_key(AssembledFrame& frame) const noexcept {
  frame.key_bytes_ = 0;
  frame.key_serial = 0;
  if (key_serial_ < first_key_serial_) return;
  const std::uint32_t kept = std::min(key_serial_ - first_key_serial_ + 1, key_slots_);
  std::uint32_t serial = key_serial_;
  // Newest first; when all are newer than the frame the oldest is as good as any: slices name the
  // key they need by its hash.
  for (std::uint32_t i = 1; i < kept; ++i, --serial)
    if (distance(keys_[serial % key_slots_].frame, frame.frame) >= 0) break;
  const Key& key = keys_[serial % key_slots_];
  std::memcpy(frame.key_, key.data, key.bytes);
  frame.key_bytes_ = key.bytes;
  frame.key_serial = serial;
}

void StreamAssembler::finish_call() noexcept {
  next_deadline_ns_ = kNever;
  for (std::size_t i = 0; i < pending_count_; ++i)
    next_deadline_ns_ =
        std::min(next_deadline_ns_, slots_[pending_[i]].first_ns + config_.deadline_ns);
  box_.store(statistics_);
}

FrameRef StreamAssembler::take() noexcept {
  const int slot = ring_.take();
  if (slot == OverwriteRing::kNone) return {};
  taken_.fetch_add(1, std::memory_order_relaxed);
  return {&slots_[slot], &ring_, slot};
}

void StreamAssembler::snapshot(StreamStatistics& out) const noexcept {
  const std::uint64_t taken = taken_.load(std::memory_order_relaxed);
  box_.load(out);
  out.frames_taken = taken;
  out.unknown_keys = unknown_keys_.load(std::memory_order_relaxed);
}

void FrameRef::reset() noexcept {
  if (frame_ == nullptr) return;
  frame_ = nullptr;
  ring_->release(slot_);
}

}  // namespace planecast
