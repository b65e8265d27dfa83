// What the receiving thread says about each frame, and the queue that carries it to the thread that
// reports: fixed memory, neither side waits.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include "core/base/status.hpp"

namespace planecast {

/// How a frame that the assembler handed on ended.
enum class FrameEnd : std::uint8_t {
  kComplete,  ///< every slice arrived and decoded
  kPartial,   ///< some slices are missing or were refused
  kNoKey,     ///< none of its slices could be read for want of their key packet
  kRefused,   ///< its key packet was refused (see status), e.g. larger than --max-size
};

/// One frame; plain data.
struct FrameRecord {
  FrameEnd end = FrameEnd::kComplete;
  Status status = Status::kOk;  ///< of the key packet or of the first slice refused
  std::uint16_t stream = 0;
  std::uint32_t session = 0;
  std::uint32_t frame = 0;
  std::uint16_t slice_count = 0;
  std::uint16_t slices = 0;          ///< received
  std::uint32_t slices_refused = 0;  ///< received, but not decodable
  std::uint64_t bytes = 0;           ///< of the slices received
  std::uint32_t points = 0;
  std::uint32_t surfaces = 0;
  std::int64_t decode_ns = 0;    ///< slices to readable cloud, wall clock
  std::int64_t latency_ns = -1;  ///< stamp to readable cloud; -1: no shared clock
  std::int64_t key_age_ns = 0;   ///< since the newest key packet
  bool sink_dropped = false;     ///< the sinks were busy: it was not handed to them
  // With --reference:
  bool checked = false;
  bool comparable = false;
  std::uint32_t missing = 0;
  std::uint32_t dropped = 0;
  std::uint32_t invented = 0;
  double max_error_m = 0;
  double max_ratio = 0;
};

/// One producer, one consumer.
class RecordQueue {
 public:
  /// Producer; false when full: the record is lost, and counted by the caller.
  bool try_push(const FrameRecord& record) noexcept {
    const std::size_t tail = tail_.load(std::memory_order_relaxed);
    if (tail - head_.load(std::memory_order_acquire) == kRecords) return false;
    records_[tail % kRecords] = record;
    tail_.store(tail + 1, std::memory_order_release);
    return true;
  }

  /// Consumer; false when empty.
  bool try_pop(FrameRecord& record) noexcept {
    const std::size_t head = head_.load(std::memory_order_relaxed);
    if (head == tail_.load(std::memory_order_acquire)) return false;
    record = records_[head % kRecords];
    head_.store(head + 1, std::memory_order_release);
    return true;
  }

 private:
  static constexpr std::size_t kRecords =
      4096;  // minutes of frames: the reporter looks every 50 ms
  std::array<FrameRecord, kRecords> records_{};
  std::atomic<std::size_t> head_{0};
  std::atomic<std::size_t> tail_{0};
};

}  // namespace planecast
