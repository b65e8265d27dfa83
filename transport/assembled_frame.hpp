// One frame as it came over the network: its slices, those missing, and the key packet to read it
// with. Lives in the assembler's memory; FrameRef gives it back.
#pragma once

#include <cstdint>
#include <span>
#include <utility>

namespace planecast {

class OverwriteRing;

class AssembledFrame {
 public:
  std::uint16_t stream = 0;
  std::uint32_t session = 0;
  std::uint32_t frame = 0;
  std::int64_t stamp_ns = 0;  ///< time of capture on the sender's clock
  std::int64_t first_ns = 0;  ///< first slice arrived, monotonic clock
  std::int64_t ready_ns = 0;  ///< handed on, monotonic clock
  std::uint16_t slice_count = 0;
  std::uint16_t slices_received = 0;
  std::uint32_t key_serial = 0;  ///< changes with every key packet of the stream; 0: no key yet

  bool complete() const noexcept { return slices_received == slice_count; }

  /// The packet of slice `index` (below slice_count), empty when it is missing.
  std::span<const std::uint8_t> slice(std::uint16_t index) const noexcept {
    return {bytes_ + table_[index].offset, table_[index].bytes};
  }

  /// The newest key packet that is not newer than this frame, empty when none has arrived. A caller
  /// parses it only when key_serial differs from the last one parsed.
  std::span<const std::uint8_t> key() const noexcept { return {key_, key_bytes_}; }

 private:
  friend class StreamAssembler;
  struct Slice {
    std::uint32_t offset;
    std::uint32_t bytes;  ///< 0: missing
  };
  std::uint8_t* bytes_ = nullptr;
  Slice* table_ = nullptr;
  std::uint8_t* key_ = nullptr;
  std::uint32_t used_ = 0;
  std::uint32_t key_bytes_ = 0;
  std::uint16_t highest_slice_ = 0;
};

/// A taken frame; gives its memory back when destroyed. For the consumer thread; must not outlive
/// the receiver.
class FrameRef {
 public:
  FrameRef() noexcept = default;
  FrameRef(const AssembledFrame* frame, OverwriteRing* ring, int slot) noexcept
      : frame_(frame), ring_(ring), slot_(slot) {}
  FrameRef(FrameRef&& other) noexcept
      : frame_(std::exchange(other.frame_, nullptr)), ring_(other.ring_), slot_(other.slot_) {}
  FrameRef& operator=(FrameRef&& other) noexcept {
    if (this != &other) {
      reset();
      frame_ = std::exchange(other.frame_, nullptr);
      ring_ = other.ring_;
      slot_ = other.slot_;
    }
    return *this;
  }
  ~FrameRef() { reset(); }

  explicit operator bool() const noexcept { return frame_ != nullptr; }
  const AssembledFrame& operator*() const noexcept { return *frame_; }
  const AssembledFrame* operator->() const noexcept { return frame_; }

  /// Gives the frame back now.
  void reset() noexcept;

 private:
  const AssembledFrame* frame_ = nullptr;
  OverwriteRing* ring_ = nullptr;
  int slot_ = 0;
};

}  // namespace planecast
