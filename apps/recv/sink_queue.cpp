#include "apps/recv/sink_queue.hpp"

#include <algorithm>
#include <string>

namespace planecast {

Status SinkQueue::layout(Arena& arena, std::uint32_t slots, std::uint32_t pixels) {
  if (const Status status = pool_.init(arena, slots); status != Status::kOk) return status;
  if (const Status status = filled_.init(arena, slots); status != Status::kOk) return status;
  for (SinkFrame& frame : frames_) {
    frame.cloud = arena.take<Point3f>(pixels);
    frame.depth = arena.take<std::uint16_t>(pixels);
    frame.labels = arena.take<std::uint8_t>(pixels);
  }
  return arena.failed() ? Status::kOutOfArena : Status::kOk;
}

std::size_t SinkQueue::memory_bytes(std::uint32_t slots, std::uint32_t pixels) {
  Arena arena = Arena::measuring();
  SinkQueue queue;
  queue.frames_.resize(slots);
  (void)queue.layout(arena, slots, pixels);
  return arena.bytes_needed();
}

Result<std::unique_ptr<SinkQueue>> SinkQueue::create(std::uint32_t slots, std::uint32_t pixels) {
  auto arena = Arena::map(memory_bytes(slots, pixels));
  if (!arena.ok()) return arena.error();
  std::unique_ptr<SinkQueue> queue(new SinkQueue);
  queue->arena_ = std::move(*arena);
  queue->frames_.resize(slots);
  if (const Status status = queue->layout(queue->arena_, slots, pixels); status != Status::kOk)
    return Error{status, "the memory of the sinks could not be laid out"};
  queue->arena_.seal();
  return queue;
}

bool SinkQueue::offer(const Decoder& decoder, const SinkFrame& who) noexcept {
  if (decoder.cloud().size() > frames_[0].cloud.size()) return false;
  const auto handle = pool_.claim();
  if (!handle) return false;
  SinkFrame& frame = frames_[*handle];
  frame.config = decoder.config();
  frame.stream = who.stream;
  frame.frame = who.frame;
  frame.sender = who.sender;
  frame.stamp_ns = who.stamp_ns;
  frame.complete = who.complete;
  frame.pixels = static_cast<std::uint32_t>(decoder.cloud().size());
  std::copy(decoder.cloud().begin(), decoder.cloud().end(), frame.cloud.begin());
  std::copy(decoder.depth().begin(), decoder.depth().end(), frame.depth.begin());
  std::copy(decoder.labels().begin(), decoder.labels().end(), frame.labels.begin());
  return filled_.try_push(*handle);  // the ring has room for every handle
}

const SinkFrame* SinkQueue::take() noexcept {
  std::uint32_t handle = 0;
  return filled_.pop_wait(handle) ? &frames_[handle] : nullptr;
}

void SinkQueue::release(const SinkFrame* frame) noexcept {
  pool_.release(static_cast<std::uint32_t>(frame - frames_.data()));
}

}  // namespace planecast
