// Every byte that the daemon takes for frames, known before it starts: the plan is laid out by the
// same code that carves the memory, so plan and use agree exactly.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/base/arena.hpp"
#include "core/base/status.hpp"
#include "core/pipeline/encoder.hpp"
#include "transport/publisher.hpp"

namespace planecast {

/// What the plan depends on.
struct MemoryNeeds {
  EncoderConfig encoder;
  PublisherConfig publisher;
  std::uint64_t preloaded_frames = 0;  ///< held decoded, all of the encoder's size
};

/// Bytes by who holds them. arena = what one mapping holds: encoder, publisher, preloaded frames
/// and the padding between them.
struct MemoryPlan {
  std::size_t encoder = 0;
  std::size_t publisher = 0;
  std::uint64_t preloaded = 0;
  std::size_t arena = 0;
  std::vector<std::string> threads;  ///< by name, those that touch frames
  std::size_t stack = 0;             ///< of one thread: a mapping of its own, all of it present
  std::size_t stacks() const { return threads.size() * stack; }
  std::uint64_t total() const { return std::uint64_t{arena} + stacks(); }
};

/// Bytes of one decoded frame of this stream.
std::size_t frame_bytes(const StreamConfig& config);

/// The plan. kBadConfig, kFieldRange as Encoder::memory_bytes; kOutOfArena: more than the machine
/// can address.
Result<MemoryPlan> plan_memory(const MemoryNeeds& needs);

/// The memory itself, mapped and carved in the plan's order; the publisher takes the rest.
struct DaemonMemory {
  Arena arena;
  std::span<std::byte> encoder;
  std::vector<std::span<std::byte>> preloaded;  ///< frame by frame
};

/// Maps plan.arena bytes. kOutOfArena.
Result<DaemonMemory> take_memory(const MemoryNeeds& needs, const MemoryPlan& plan,
                                 ArenaOptions options);

/// "name bytes note" lines for people and scripts; the last is "total". `resident`: what the
/// process holds in RAM beside the plan.
std::vector<std::string> to_lines(const MemoryPlan& plan, const MemoryNeeds& needs,
                                  std::uint64_t resident);

/// A publisher that holds any frame of the stream, in messages of at most `message_bytes`.
PublisherConfig publisher_for(const EncoderConfig& encoder, const std::string& channel,
                              std::uint32_t message_bytes);

}  // namespace planecast
