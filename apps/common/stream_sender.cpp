#include "apps/common/stream_sender.hpp"

#include <algorithm>

namespace planecast {
namespace {

constexpr std::int64_t kWaitNs = 20'000'000;
constexpr std::uint64_t kMostQueued = 2;  // frames, with `wait`

// Only the sender writes these. Release, so that who reads one also sees those raised before it.
void add(std::atomic<std::uint64_t>& counter, std::uint64_t amount) noexcept {
  counter.store(counter.load(std::memory_order_relaxed) + amount, std::memory_order_release);
}

}  // namespace

std::uint32_t key_interval(double rate_hz) noexcept {
  const double frames = rate_hz * static_cast<double>(kKeyPeriodNs) * 1e-9;
  return static_cast<std::uint32_t>(std::clamp(frames, 1.0, 1e6));
}

void StreamSender::run() noexcept {
  EncodedFrame frame;
  while (encoder_.next(frame)) {
    send(frame);
    encoder_.release(frame);
  }
}

void StreamSender::send(const EncodedFrame& frame) noexcept {
  if (frame.status != Status::kOk) {
    fail(frame.status, failed_);
    return;
  }
  if (config_.wait) wait_for_publisher();
  FrameBuffer* buffer = publisher_.claim();
  if (buffer == nullptr) {
    fail(Status::kStopped, did_not_fit_);
    return;
  }
  const FrameSlot& slot = *frame.slot;
  const bool key = key_due(slot) || buffer->key_wanted();
  if (const Status status = fill(slot, *buffer, key); status != Status::kOk) {
    publisher_.abandon(buffer);
    fail(status, did_not_fit_);
    return;
  }
  const std::uint32_t bytes = buffer->bytes();  // the buffer is not ours after publish()
  (void)publisher_.publish(buffer);
  if (key) {
    key_sent_ = true;
    key_frame_ = slot.number;
    key_stamp_ns_ = slot.stamp_ns;
    add(keys_, 1);
  }
  count(slot, bytes);
}

Status StreamSender::fill(const FrameSlot& slot, FrameBuffer& buffer, bool key) noexcept {
  if (key) {
    const std::size_t bytes = encoder_.key_packet(slot.number, slot.stamp_ns, buffer.space());
    if (const Status status = buffer.commit(bytes, true); status != Status::kOk) return status;
  }
  for (std::uint32_t i = 0; i < slot.report.slices; ++i) {
    if (const Status status = buffer.append(slot.slice(i)); status != Status::kOk) return status;
  }
  // An image without a reading has slices as well; a frame of none would be no frame on the wire.
  return slot.report.slices > 0 ? Status::kOk : Status::kWrongSize;
}

// By frame count, so that a recording gives the same packets at any speed; by stamp, for sources
// that are slower than their nominal rate or lose frames.
bool StreamSender::key_due(const FrameSlot& slot) const noexcept {
  return !key_sent_ || slot.number - key_frame_ >= config_.key_every_frames ||
         slot.stamp_ns - key_stamp_ns_ >= kKeyPeriodNs;
}

void StreamSender::wait_for_publisher() noexcept {
  while (publisher_.statistics().frames_queued >= kMostQueued) (void)publisher_.flush(kWaitNs);
}

void StreamSender::fail(Status status, Counter& counter) noexcept {
  if (first_failure() == Status::kOk) first_failure_.store(status, std::memory_order_relaxed);
  add(counter, 1);
}

void StreamSender::count(const FrameSlot& slot, std::uint32_t bytes) noexcept {
  const std::uint64_t sent = sent_.load(std::memory_order_relaxed);
  recent_ns_[sent % kRecent].store(slot.packed_ns - slot.submitted_ns, std::memory_order_relaxed);
  add(readings_, slot.counts.input);
  add(surfaces_, slot.report.surfaces);
  add(less_effort_, slot.effort == FrameEffort::kFull ? 0 : 1);
  add(bytes_, bytes);
  add(out_of_range_, slot.counts.out_of_range);
  add(outliers_dropped_, slot.counts.outliers_dropped);
  add(off_surface_dropped_, slot.counts.off_surface_dropped);
  last_frame_.store(slot.number, std::memory_order_relaxed);
  add(sent_, 1);
}

SenderTotals StreamSender::totals() const noexcept {
  const auto get = [](const Counter& counter) { return counter.load(std::memory_order_acquire); };
  SenderTotals out;
  out.sent = get(sent_);
  out.failed = get(failed_);
  out.did_not_fit = get(did_not_fit_);
  out.keys = get(keys_);
  out.readings = get(readings_);
  out.surfaces = get(surfaces_);
  out.less_effort = get(less_effort_);
  out.bytes = get(bytes_);
  out.out_of_range = get(out_of_range_);
  out.outliers_dropped = get(outliers_dropped_);
  out.off_surface_dropped = get(off_surface_dropped_);
  out.last_frame = get(last_frame_);
  return out;
}

std::int64_t StreamSender::encode_median_ns(std::uint64_t seen) const noexcept {
  const std::uint64_t sent = sent_.load(std::memory_order_acquire);
  const auto count =
      static_cast<std::size_t>(std::min<std::uint64_t>(sent - std::min(seen, sent), kRecent));
  if (count == 0) return 0;
  std::array<std::int64_t, kRecent> times{};
  for (std::size_t i = 0; i < count; ++i)
    times[i] = recent_ns_[(sent - count + i) % kRecent].load(std::memory_order_relaxed);
  const auto middle = times.begin() + static_cast<std::ptrdiff_t>(count / 2);
  std::nth_element(times.begin(), middle, times.begin() + static_cast<std::ptrdiff_t>(count));
  return *middle;
}

}  // namespace planecast
