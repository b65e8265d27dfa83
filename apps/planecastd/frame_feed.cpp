#include "apps/planecastd/frame_feed.hpp"

#include <cstring>
#include <utility>

namespace planecast {

Result<Done> FrameFeed::preload(std::vector<std::span<std::byte>> memory,
                                const std::function<bool()>& stop_asked) {
  for (const std::span<std::byte> place : memory) {
    if (stop_asked()) return {Status::kStopped, "stopped while the input was read"};
    FeedFrame frame;
    const auto got = read(frame);
    if (!got) return got.error();
    if (!*got) return {Status::kUnreadable, "the input has fewer frames than it had a moment ago"};
    const auto bytes =
        frame.points.empty() ? std::as_bytes(frame.depth) : std::as_bytes(frame.points);
    std::memcpy(place.data(), bytes.data(), place.size());
    stamps_.push_back(frame.stamp_ns);
  }
  memory_ = std::move(memory);
  return Done{};
}

Result<bool> FrameFeed::next(FeedFrame& frame) {
  if (memory_.empty()) {
    for (;;) {
      const auto got = read(frame);
      if (!got || *got) return got;
      if (config_.live || given_in_pass_ == 0 || !another_pass()) return false;
      source_.rewind();
      given_in_pass_ = 0;
    }
  }
  if (at_ == memory_.size()) {
    if (!another_pass()) return false;
    at_ = 0;
  }
  frame = from_memory(at_++);
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
    if (!config_.live) return done.error();
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
  if (setup_.encoder.stream.kind != FrameKind::kRawCloud) {
    if (const auto done = to_depth(setup_, raw_, depth_); !done) return done.error();
    frame.depth = depth_;
    return Done{};
  }
  const CameraModel& camera = setup_.encoder.stream.camera;
  if (raw_.cloud.width != camera.width || raw_.cloud.height != camera.height)
    return {Status::kUnreadable, raw_.name + ": its size differs from the stream's first frame"};
  frame.points = raw_.cloud.points;
  return Done{};
}

FeedFrame FrameFeed::from_memory(std::size_t index) const {
  FeedFrame frame;
  const std::span<std::byte> bytes = memory_[index];
  if (setup_.encoder.stream.kind == FrameKind::kRawCloud) {
    frame.points = {reinterpret_cast<const Point3f*>(bytes.data()), bytes.size() / sizeof(Point3f)};
  } else {
    frame.depth = {reinterpret_cast<const std::uint16_t*>(bytes.data()),
                   bytes.size() / sizeof(std::uint16_t)};
  }
  frame.stamp_ns = stamps_[index];
  return frame;
}

}  // namespace planecast
