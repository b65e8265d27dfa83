#include "apps/planecastd/frame_player.hpp"

#include <cmath>

namespace planecast {

void FramePlayer::run() {
  const std::int64_t period_ns = config_.rate_hz ? std::llround(1e9 / *config_.rate_hz) : 0;
  std::int64_t due_ns = monotonic_ns();
  while (!stop_.load(std::memory_order_acquire)) {
    FeedFrame frame;
    const auto got = feed_.next(frame);
    if (!got) error_ = got.error();
    if (!got || !*got) break;
    if (config_.rate_hz) {
      if (!wait_until(due_ns)) break;
      frame.stamp_ns = monotonic_ns();
      // A source that fell behind by more than a period goes on from here: nothing is caught up in
      // a burst, as no sensor would.
      due_ns += period_ns;
      if (due_ns + period_ns < frame.stamp_ns) due_ns = frame.stamp_ns;
    }
    submit(frame);
  }
  finished_.store(true, std::memory_order_release);
}

void FramePlayer::submit(const FeedFrame& frame) noexcept {
  // A frame that gets no slot is counted by the encoder; its number stays unused on the wire, so
  // receivers see the gap.
  const std::uint64_t number = number_++;
  out_of_range_.fetch_add(frame.out_of_range, std::memory_order_relaxed);
  if (encoder_.config().stream.kind == FrameKind::kDepth) {
    (void)encoder_.submit(DepthView{frame.depth, number, frame.stamp_ns}, config_.wait);
  } else {
    (void)encoder_.submit(frame.points, number, frame.stamp_ns, config_.wait);
  }
}

bool FramePlayer::wait_until(std::int64_t due_ns) noexcept {
  while (monotonic_ns() < due_ns) {
    if (stop_.load(std::memory_order_acquire)) return false;
    (void)stopped_.wait_until(due_ns);
  }
  return !stop_.load(std::memory_order_acquire);
}

void FramePlayer::stop() noexcept {
  stop_.store(true, std::memory_order_release);
  stopped_.notify();
}

}  // namespace planecast
