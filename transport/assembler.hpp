// Puts packets together into frames, several streams side by side, in fixed memory. A frame is
// handed on when complete, at a deadline, or when the frame `frames_in_assembly` after it begins,
// always in the order of frame numbers; what is missing is named, what is dropped is counted.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "core/base/arena.hpp"
#include "core/base/status.hpp"
#include "transport/assembled_frame.hpp"
#include "transport/packet_info.hpp"
#include "transport/statistics.hpp"

namespace planecast {

/// The clock of PacketInfo::stamp_ns, as far as this host shares it with the sender.
enum class StampClock : std::uint8_t { kUnknown, kMonotonic, kRealtime };

struct AssemblerConfig {
  std::uint16_t max_streams = 4;              ///< 1 .. kMaxStreams
  std::uint32_t max_slices = 2048;            ///< slices a frame, 1 .. 65535
  std::uint32_t max_frame_bytes = 2U << 20U;  ///< packets of one frame together
  std::uint32_t max_key_bytes = 1500;         ///< largest key packet
  std::uint8_t frame_bits = 32;               ///< 16 .. 32; frame numbers wrap at 2^frame_bits
  std::uint16_t frames_in_assembly = 2;       ///< 1 .. 8; frame n + this closes frame n
  std::uint16_t output_frames = 1;            ///< finished frames kept; 1: the newest only
  std::uint16_t held_frames = 1;              ///< frames the consumer holds at a time
  std::int64_t deadline_ns = 33'333'333;      ///< from a frame's first slice until it is handed on
  std::int64_t session_timeout_ns = 1'000'000'000;  ///< a replaced sender is heard again after this
                                                    ///< much silence of its successor
  StampClock stamp_clock = StampClock::kUnknown;    ///< known: capture latency is measured
};

class Assembler {
 public:
  /// Bytes of frame memory for this configuration; all taken at creation.
  static std::size_t memory_bytes(const AssemblerConfig& config) noexcept;

  /// The frame memory is taken from `arena`, which must outlive the assembler, or without one
  /// mapped by itself. kBadConfig, kOutOfArena.
  static Result<std::unique_ptr<Assembler>> create(const AssemblerConfig& config,
                                                   Arena* arena = nullptr);
  ~Assembler();

  // The receiving thread; these never wait and never allocate.

  /// Takes one packet in (copied). `now_ns` is the monotonic clock. O(packet).
  void push(std::span<const std::uint8_t> packet, const PacketInfo& info,
            std::int64_t now_ns) noexcept;

  /// Hands on the frames whose deadline has passed.
  void poll(std::int64_t now_ns) noexcept;

  /// When poll() has something to do; INT64_MAX when nothing is in assembly.
  std::int64_t next_deadline_ns() const noexcept;

  /// Counters of what comes before a stream; call publish_link() after a change.
  LinkStatistics& link() noexcept;
  void publish_link() noexcept;

  // The one consuming thread.

  /// The oldest finished frame (with output_frames 1: the newest), streams in turn; empty when
  /// none.
  FrameRef take() noexcept;

  /// The same of one stream.
  FrameRef take(std::uint16_t stream) noexcept;

  /// Waits for a frame of any stream; empty after `timeout_ns` or interrupt().
  FrameRef wait(std::int64_t timeout_ns) noexcept;

  /// Counts slices of `stream` whose key packet the consumer did not have.
  void count_unknown_keys(std::uint16_t stream, std::uint64_t slices) noexcept;

  // Any thread.

  /// Ends the wait() that is going on, or the next one.
  void interrupt() noexcept;

  /// A snapshot; each stream's counts are of one moment, apart from the consumer's two.
  ReceiverStatistics statistics() const noexcept;

 private:
  struct Impl;
  explicit Assembler(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace planecast
