// The last thread of a sender: takes packed frames from the encoder, puts a key packet in front
// where one is due, and hands them to the publisher. Copies bytes and counts; allocates nothing.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "core/base/status.hpp"
#include "core/pipeline/encoder.hpp"
#include "transport/publisher.hpp"

namespace planecast {

/// Time within which a receiver that joins has its key packet [ns].
inline constexpr std::int64_t kKeyPeriodNs = 250'000'000;

/// Frames from one key packet to the next at `rate_hz`, so that at most kKeyPeriodNs pass.
std::uint32_t key_interval(double rate_hz) noexcept;

struct SenderConfig {
  std::uint32_t key_every_frames = 7;  ///< key_interval()
  bool wait = false;  ///< wait for the publisher instead of letting it drop its oldest frame
};

/// Totals since the start. All frames that came from the encoder: sent + failed + did_not_fit.
struct SenderTotals {
  std::uint64_t sent = 0;    ///< handed to the publisher
  std::uint64_t failed = 0;  ///< came from the encoder with a status
  std::uint64_t did_not_fit =
      0;                   ///< larger than a frame buffer of the publisher, or it was stopped
  std::uint64_t keys = 0;  ///< key packets sent
  // Of the frames sent:
  std::uint64_t readings = 0;
  std::uint64_t surfaces = 0;
  std::uint64_t less_effort = 0;  ///< frames that got less than full effort, for --budget-ms
  std::uint64_t bytes = 0;  ///< LCM payload, key packets and envelopes included
  std::uint64_t out_of_range = 0, outliers_dropped = 0, off_surface_dropped = 0;  ///< points
  std::uint64_t last_frame = 0;                                                   ///< its number
};

class StreamSender {
 public:
  /// Both must outlive the sender, and be its own: it is the encoder's consumer thread and the
  /// publisher's pipeline thread.
  StreamSender(Encoder& encoder, Publisher& publisher, const SenderConfig& config) noexcept
      : encoder_(encoder), publisher_(publisher), config_(config) {}

  /// The sender thread: returns once the encoder is stopped and empty.
  void run() noexcept;

  /// Any thread; fields may be one frame apart while the sender runs.
  SenderTotals totals() const noexcept;

  /// Any thread: status of the first frame that failed, kOk while none has.
  Status first_failure() const noexcept { return first_failure_.load(std::memory_order_relaxed); }

  /// Any thread: median of submitted-to-packed of the frames after the first `seen` of
  /// totals().sent (the latest 256 at most) [ns]; 0 when there are none. O(256).
  std::int64_t encode_median_ns(std::uint64_t seen) const noexcept;

 private:
  static constexpr std::size_t kRecent = 256;
  using Counter = std::atomic<std::uint64_t>;

  void send(const EncodedFrame& frame) noexcept;
  Status fill(const FrameSlot& slot, FrameBuffer& buffer, bool key) noexcept;
  bool key_due(const FrameSlot& slot) const noexcept;
  void wait_for_publisher() noexcept;
  void fail(Status status, Counter& counter) noexcept;
  void count(const FrameSlot& slot, std::uint32_t bytes) noexcept;

  Encoder& encoder_;
  Publisher& publisher_;
  SenderConfig config_;
  bool key_sent_ = false;
  std::uint64_t key_frame_ = 0;
  std::int64_t key_stamp_ns_ = 0;

  Counter sent_{0}, failed_{0}, did_not_fit_{0}, keys_{0}, readings_{0}, surfaces_{0}, bytes_{0};
  Counter less_effort_{0}, out_of_range_{0}, outliers_dropped_{0}, off_surface_dropped_{0}, last_frame_{0};
  std::atomic<Status> first_failure_{Status::kOk};
  std::array<std::atomic<std::int64_t>, kRecent> recent_ns_{};
};

}  // namespace planecast
