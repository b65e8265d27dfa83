// The receiving thread: takes frames from the assembler, decodes and regenerates each with its
// stream's own decoder, checks it, hands a copy to the sinks and a record to the reporter. No
// allocation and no waiting but for the next frame.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

#include "apps/common/reference_check.hpp"
#include "apps/recv/frame_record.hpp"
#include "apps/recv/sink_queue.hpp"
#include "core/base/status.hpp"
#include "core/pipeline/decoder.hpp"
#include "core/pipeline/frame_team.hpp"
#include "transport/subscriber.hpp"

namespace planecast {

struct ReceiveConfig {
  std::uint16_t streams = 4;
  FrameLimits limits{1280, 1024};
  std::uint64_t frames = 0;      ///< end after this many, lost ones included; 0: no end
  std::uint32_t boot_id = 0;     ///< of this host (boot_id_hash)
  std::int64_t deadline_ns = 0;  ///< a frame that takes longer counts as late; 0: none does
  void (*on_thread_start)(const char* name) =
      nullptr;  ///< first on the thread that helps to decode
};

class ReceiveLoop {
 public:
  /// Bytes of the decoders.
  static std::size_t memory_bytes(const ReceiveConfig& config) noexcept;

  /// Takes all memory. `reference` and `sinks` may be null; all must outlive the loop. kOutOfArena.
  static Result<std::unique_ptr<ReceiveLoop>> create(const ReceiveConfig& config,
                                                     Subscriber& subscriber,
                                                     const ReferenceCheck* reference,
                                                     SinkQueue* sinks);

  /// The receiving thread: returns after the last frame asked for, or after stop(); closes the
  /// sinks' queue.
  void run() noexcept;

  /// Any thread.
  void stop() noexcept;
  bool finished() const noexcept { return finished_.load(std::memory_order_acquire); }

  /// The reporting thread's end.
  RecordQueue& records() noexcept { return records_; }
  /// Records that found the queue full.
  std::uint64_t records_lost() const noexcept {
    return records_lost_.load(std::memory_order_relaxed);
  }

  /// Frames that took longer than the deadline.
  std::uint64_t late() const noexcept { return late_.load(std::memory_order_relaxed); }
  /// Any thread: for how long the frame in hand has been worked on [ns]; 0 without one.
  std::int64_t busy_ns(std::int64_t now_ns) const noexcept {
    const std::int64_t since_ns = busy_since_ns_.load(std::memory_order_relaxed);
    return since_ns == 0 ? 0 : now_ns - since_ns;
  }

 private:
  struct Stream {
    bool used = false;
    std::uint16_t number = 0;
    std::uint32_t session = 0;
    std::uint32_t senders = 0;  ///< sessions seen
    std::uint32_t last_frame = 0;
    std::uint32_t key_serial = 0;
    std::int64_t key_ns = 0;  ///< the newest key packet came, monotonic clock
    std::int64_t last_stamp_ns = 0;
    Status key_status = Status::kUnknownKey;
    std::unique_ptr<Decoder> decoder;
  };

  ReceiveLoop(const ReceiveConfig& config, Subscriber& subscriber, const ReferenceCheck* reference,
              SinkQueue* sinks)
      : config_(config), subscriber_(subscriber), reference_(reference), sinks_(sinks) {}

  Stream& stream_of(std::uint16_t number) noexcept;
  void work_on(const AssembledFrame& frame) noexcept;
  void take(const AssembledFrame& frame) noexcept;
  void follow_session(Stream& stream, const AssembledFrame& frame) noexcept;
  void take_key(Stream& stream, const AssembledFrame& frame) noexcept;
  void decode(Stream& stream, const AssembledFrame& frame, FrameRecord& record) noexcept;
  void judge(const Stream& stream, const AssembledFrame& frame, FrameRecord& record) noexcept;
  void measure_latency(Stream& stream, const AssembledFrame& frame, FrameRecord& record) noexcept;
  void check(const Stream& stream, FrameRecord& record) const noexcept;
  void hand_over(const Stream& stream, FrameRecord& record) noexcept;

  ReceiveConfig config_;
  Subscriber& subscriber_;
  const ReferenceCheck* reference_;
  SinkQueue* sinks_;
  FrameTeam team_;  ///< helps whichever decoder works
  std::vector<Stream> streams_;
  std::uint64_t frames_passed_ = 0;
  RecordQueue records_;
  std::atomic<std::uint64_t> records_lost_{0};
  std::atomic<std::uint64_t> late_{0};
  std::atomic<std::int64_t> busy_since_ns_{0};
  std::atomic<bool> stopping_{false};
  std::atomic<bool> finished_{false};
};

}  // namespace planecast
