// Frames ready to submit, in the order and as often as they are to be played: from memory when they
// were preloaded, else read one by one. The source thread's, outside the pipeline: may allocate.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "apps/common/frame_source.hpp"
#include "apps/common/stream_setup.hpp"
#include "core/base/status.hpp"

namespace planecast {

/// One frame in the encoder's form; valid until the next call of FrameFeed::next().
struct FeedFrame {
  std::span<const std::uint16_t> depth;  ///< counts; empty for raw-cloud streams
  std::span<const Point3f> points;       ///< raw-cloud streams and lists
  std::int64_t stamp_ns = 0;             ///< the source's own
  std::uint32_t out_of_range = 0;        ///< readings of a raw cloud made holes by --range
};

struct FeedConfig {
  std::uint64_t repeat = 1;  ///< passes over the input; 0: without end
  bool live = false;         ///< frames that do not fit the stream are counted, not an error
};

class FrameFeed {
 public:
  /// `first` is the frame that `source` gave already; source and setup must outlive the feed.
  FrameFeed(FrameSource& source, const StreamSetup& setup, SensorFrame first,
            const FeedConfig& config)
      : source_(source), setup_(setup), config_(config), raw_(std::move(first)) {}

  /// Decodes the first pass into `memory`, one frame each (frame_bytes()). Errors name the frame;
  /// kStopped when `stop_asked` said so, asked once a frame.
  Result<Done> preload(std::span<const std::span<std::byte>> memory,
                       const std::function<bool()>& stop_asked);

  /// The next frame; false at the end. Errors name the frame.
  Result<bool> next(FeedFrame& frame);

  /// Frames refused because they do not fit the stream, and why the last one was ("" when none
  /// was): of live feeds, and lists of too many points of any. Any thread.
  std::uint64_t refused() const { return refused_.load(std::memory_order_acquire); }
  std::string refusal() const;

 private:
  Result<bool> read(FeedFrame& frame);
  Result<Done> prepare(FeedFrame& frame);
  bool another_pass();

  FrameSource& source_;
  const StreamSetup& setup_;
  FeedConfig config_;
  SensorFrame raw_;
  bool raw_is_first_ = true;
  std::vector<std::uint16_t> depth_;
  std::vector<Point3f> points_;
  std::vector<FeedFrame> loaded_;  ///< in memory
  std::size_t at_ = 0;
  std::uint64_t passes_ = 1;  ///< begun
  std::uint64_t given_in_pass_ = 0;
  std::atomic<std::uint64_t> refused_{0};
  mutable std::mutex refusal_mutex_;
  std::string refusal_;
};

}  // namespace planecast
