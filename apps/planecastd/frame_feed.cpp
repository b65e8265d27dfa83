#include "apps/planecastd/frame_feed.hpp"

#include <cstring>
#include <utility>

#include "apps/common/points_setup.hpp"

namespace planecast {
namespace {

template <class T>
std::span<const T> copied(std::span<const T> from, std::span<std::byte> to) {
  std::memcpy(to.data(), from.data(), from.size_bytes());
  return {reinterpret_cast<const T*>(to.data()), from.size()};
}

FeedFrame copied(FeedFrame frame, std::span<std::byte> to) {
  if (frame.points.empty()) {
    frame.depth = copied(frame.depth, to);
  } else {
    frame.points = copied(frame.points, to);
  }
  return frame;
}

}  // namespace

Result<Done> FrameFeed::preload(std::span<const std::span<std::byte>> memory,
                                const std::function<bool()>& stop_asked) {
  for (const std::span<std::byte> place : memory) {
    if (stop_asked()) return {Status::kStopped, "stopped while the input was read"};
    FeedFrame frame;
    const auto got = read(frame);
    if (!got) return got.error();
    if (!*got && refused() > 0) break;
    if (!*got) return {Status::kUnreadable, "the input has fewer frames than it had a moment ago"};
    loaded_.push_back(copied(frame, place));
  }
  return Done{};
}

Result<bool> FrameFeed::next(FeedFrame& frame) {
  if (loaded_.empty()) {
    for (;;) {
      const auto got = read(frame);
      if (!got || *got) return got;
      if (config_.live || given_in_pass_ == 0 || !another_pass()) return false;
      source_.rewind();
      given_in_pass_ = 0;
    }
  }
  if (at_ == loaded_.size()) {
    if (!another_pass()) return false;
    at_ = 0;
  }
  frame = loaded_[at_++];
  return true;
}

bool FrameFeed::another_pass() {
  if (config_.repeat != 0 && passes_ >= config_.repeat) return false;
  ++passes_;
  return true;
}

Result<bool> FrameFeed::read(FeedFrame& frame) {
  for (;;) {
    if (!std::exchange(raw_is_first_, false)) {
      const auto got = source_.next(raw_);
      if (!got || !*got) return got;
    }
    const auto done = prepare(frame);
    if (done) {
      ++given_in_pass_;
      return true;
    }
    // A list may have any number of points; one too large is no fault of the others.
    const bool goes_on = config_.live || done.error().status == Status::kFrameTooLarge;
    if (!goes_on) return done.error();
    refused_.fetch_add(1, std::memory_order_release);
    const std::lock_guard lock(refusal_mutex_);
    refusal_ = done.error().message;
  }
}

std::string FrameFeed::refusal() const {
  const std::lock_guard lock(refusal_mutex_);
  return refusal_;
}

Result<Done> FrameFeed::prepare(FeedFrame& frame) {
  frame = {};
  frame.stamp_ns = raw_.stamp_ns;
  if (setup_.encoder.stream.kind == FrameKind::kPoints) {
    if (const auto done = to_points(setup_, raw_, points_); !done) return done.error();
    frame.points = points_;
  } else if (setup_.encoder.stream.kind == FrameKind::kRawCloud) {
    const auto gated = to_raw_points(setup_, raw_, points_);
    if (!gated) return gated.error();
    frame.out_of_range = *gated;
    frame.points = points_;
  } else {
    if (const auto done = to_depth(setup_, raw_, depth_); !done) return done.error();
    frame.depth = depth_;
  }
  return Done{};
}

}  // namespace planecast
