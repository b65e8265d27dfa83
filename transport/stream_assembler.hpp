// One stream's part of the assembler: its session, the frames in assembly, its key packets and its
// output ring. Internal to transport/; the rules are in assembler.hpp.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <limits>
#include <span>

#include "core/base/arena.hpp"
#include "transport/assembled_frame.hpp"
#include "transport/assembler.hpp"
#include "transport/overwrite_ring.hpp"
#include "transport/packet_info.hpp"
#include "transport/snapshot_box.hpp"
#include "transport/statistics.hpp"

namespace planecast {

class StreamAssembler {
 public:
  static constexpr std::size_t kMaxInAssembly = 8;

  /// Takes this stream's memory, or with a measuring arena only counts it.
  void lay_out(const AssemblerConfig& config, Arena& arena) noexcept;

  /// Receiving thread, before the first packet.
  void begin(std::uint16_t stream) noexcept { statistics_.stream = stream; }
  std::uint16_t stream() const noexcept { return statistics_.stream; }

  /// Receiving thread. True when at least one frame was handed on.
  bool push(std::span<const std::uint8_t> packet, const PacketInfo& info,
            std::int64_t now_ns) noexcept;
  bool poll(std::int64_t now_ns) noexcept;
  std::int64_t next_deadline_ns() const noexcept { return next_deadline_ns_; }

  /// Consuming thread.
  FrameRef take() noexcept;
  void count_unknown_keys(std::uint64_t slices) noexcept {
    unknown_keys_.fetch_add(slices, std::memory_order_relaxed);
  }

  /// Any thread.
  void snapshot(StreamStatistics& out) const noexcept;

 private:
  enum class Place : std::uint8_t { kOld, kCurrent };
  struct Key {
    std::uint32_t frame = 0;
    std::uint32_t bytes = 0;
    std::uint8_t* data = nullptr;
  };
  struct Closed {
    std::uint32_t frame = 0;
    bool known = false;
    bool complete = false;
  };

  std::int32_t distance(std::uint32_t from, std::uint32_t to) const noexcept {
    return frame_distance(from, to, config_.frame_bits);
  }
  bool enter_session(const PacketInfo& info, std::int64_t now_ns) noexcept;
  bool retired(std::uint32_t session) const noexcept;
  void start_session(const PacketInfo& info) noexcept;
  void restart_numbers(std::uint32_t frame) noexcept;
  Place place(std::uint32_t frame, std::int64_t now_ns) noexcept;
  void take_key(std::span<const std::uint8_t> packet, const PacketInfo& info,
                std::int64_t now_ns) noexcept;
  void take_slice(std::span<const std::uint8_t> packet, const PacketInfo& info,
                  std::int64_t now_ns) noexcept;
  AssembledFrame* frame_of(const PacketInfo& info, std::int64_t now_ns) noexcept;
  bool store(AssembledFrame& frame, std::span<const std::uint8_t> packet,
             const PacketInfo& info) noexcept;
  void count_late(const PacketInfo& info) noexcept;
  void measure_jitter(const PacketInfo& info, std::int64_t now_ns) noexcept;
  void hand_on_through(std::uint32_t frame, std::int64_t now_ns) noexcept;
  void hand_on(int slot, std::int64_t now_ns) noexcept;
  void attach_key(AssembledFrame& frame) const noexcept;
  int oldest_pending() const noexcept;
  void remove_pending(int slot) noexcept;
  void finish_call() noexcept;

  AssemblerConfig config_;
  OverwriteRing ring_;
  std::span<AssembledFrame> slots_;
  std::span<Key> keys_;
  std::uint32_t key_slots_ = 0;

  // The receiving thread's.
  StreamStatistics statistics_;
  std::array<int, kMaxInAssembly> pending_{};
  std::size_t pending_count_ = 0;
  std::array<Closed, 16> closed_{};
  std::size_t closed_next_ = 0;
  std::array<std::uint32_t, 4> retired_{};
  std::size_t retired_count_ = 0;
  bool started_ = false;
  bool counts_lost_ = false;  ///< a frame of this numbering has been handed on
  bool has_transit_ = false;
  std::uint32_t newest_ = 0;       ///< newest frame number begun
  std::uint32_t last_closed_ = 0;  ///< newest frame number handed on
  std::uint32_t key_serial_ = 0;
  std::uint32_t first_key_serial_ = 1;  ///< first key of this session and numbering
  std::int64_t last_packet_ns_ = 0;
  std::int64_t last_transit_ns_ = 0;
  std::int64_t last_stamp_ns_ = 0;
  std::int64_t next_deadline_ns_ = std::numeric_limits<std::int64_t>::max();
  std::uint64_t handed_on_ = 0;

  SnapshotBox<StreamStatistics> box_;
  // The consuming thread's.
  std::atomic<std::uint64_t> taken_{0};
  std::atomic<std::uint64_t> unknown_keys_{0};
};

}  // namespace planecast
