// The source thread: gives frames to the encoder at a steady rate on absolute deadlines, stamped
// with the moment they were in memory. Never waits for the pipeline unless told to.
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <string>

#include "apps/planecastd/frame_feed.hpp"
#include "core/base/status.hpp"
#include "core/pipeline/encoder.hpp"
#include "transport/wake.hpp"

namespace planecast {

struct PlayerConfig {
  std::optional<double> rate_hz;  ///< none: as the source gives them, with the source's stamps
  bool wait = false;              ///< wait for a free slot instead of dropping the new frame
};

class FramePlayer {
 public:
  /// Feed and encoder must outlive the player, which is the encoder's source thread.
  FramePlayer(FrameFeed& feed, Encoder& encoder, const PlayerConfig& config) noexcept
      : feed_(feed), encoder_(encoder), config_(config) {}

  /// The source thread: returns at the end of the feed, at an error, or after stop().
  void run();

  /// Any thread: ends run() before its next frame. A feed that waits is to be interrupted as well.
  void stop() noexcept;

  /// Any thread: true once run() has returned.
  bool finished() const noexcept { return finished_.load(std::memory_order_acquire); }

  /// Any thread: readings of the frames offered that --range made holes before the pipeline.
  std::uint64_t out_of_range() const noexcept {
    return out_of_range_.load(std::memory_order_relaxed);
  }

  /// Why run() ended early; kOk when it did not. After run().
  const Error& error() const noexcept { return error_; }

 private:
  bool wait_until(std::int64_t due_ns) noexcept;
  void submit(const FeedFrame& frame) noexcept;

  FrameFeed& feed_;
  Encoder& encoder_;
  PlayerConfig config_;
  Wake stopped_;
  std::atomic<bool> stop_{false};
  std::atomic<bool> finished_{false};
  std::uint64_t number_ = 0;
  std::atomic<std::uint64_t> out_of_range_{0};
  Error error_;
};

}  // namespace planecast
