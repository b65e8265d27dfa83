// Decoded frames on their way to the sinks: a few slots of fixed memory between the receiving
// thread, which never waits here, and the sink thread, which may take its time.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/base/arena.hpp"
#include "core/base/status.hpp"
#include "core/pipeline/decoder.hpp"
#include "core/ring/slot_pool.hpp"
#include "core/ring/spsc_ring.hpp"

namespace planecast {

/// A copy of what a decoder held; the spans' first `pixels` are in use.
struct SinkFrame {
  StreamConfig config;
  std::uint16_t stream = 0;
  std::uint32_t frame = 0;
  std::uint32_t sender = 1;  ///< counts the sessions of the stream from 1
  std::int64_t stamp_ns = 0;
  bool complete = false;
  std::uint32_t pixels = 0;
  std::span<Point3f> cloud;
  std::span<std::uint16_t> depth;  ///< of depth streams only
  std::span<std::uint8_t> labels;

  /// The cloud is all there is: no depth image.
  bool raw() const noexcept { return config.kind != FrameKind::kDepth; }
  bool list() const noexcept { return config.kind == FrameKind::kPoints; }
};

class SinkQueue {
 public:
  /// Bytes for `slots` frames of `pixels`.
  static std::size_t memory_bytes(std::uint32_t slots, std::uint32_t pixels);

  /// Takes all memory. kOutOfArena.
  static Result<std::unique_ptr<SinkQueue>> create(std::uint32_t slots, std::uint32_t pixels);

  // The receiving thread; allocates nothing.

  /// Copies the decoder's frame; false when every slot is in use, or the frame is larger than one:
  /// the frame is dropped.
  bool offer(const Decoder& decoder, const SinkFrame& who) noexcept;
  /// No more frames: take() ends once empty.
  void close() noexcept { filled_.close(); }

  // The sink thread.

  /// Waits for the next frame; null once closed and empty.
  const SinkFrame* take() noexcept;
  void release(const SinkFrame* frame) noexcept;

 private:
  SinkQueue() = default;
  Status layout(Arena& arena, std::uint32_t slots, std::uint32_t pixels);

  Arena arena_;
  std::vector<SinkFrame> frames_;
  SlotPool pool_;
  SpscRing filled_;
};

}  // namespace planecast
