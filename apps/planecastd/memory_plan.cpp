#include "apps/planecastd/memory_plan.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/base/thread_stack.hpp"
#include "core/wire/frame_pack.hpp"
#include "core/wire/key_packet.hpp"
#include "core/wire/raw_pack.hpp"

namespace planecast {
namespace {

constexpr std::size_t kMostFrameBytes = std::size_t{1} << 30U;  // of a publisher's buffer

// One order for measuring and carving. Whatever takes memory from the arena starts on a cache line,
// so the publisher's part begins where this ends.
void lay_out(const MemoryNeeds& needs, const MemoryPlan& plan, Arena& arena, DaemonMemory* memory) {
  const auto encoder = arena.take<std::byte>(plan.encoder);
  if (memory != nullptr) memory->encoder = encoder;
  for (std::uint64_t i = 0; i < needs.preloaded_frames; ++i) {
    const auto frame = arena.take<std::byte>(frame_bytes(needs.encoder.stream));
    if (memory != nullptr) memory->preloaded.push_back(frame);
  }
}

struct FrameMost {
  std::size_t bytes = 0, slices = 0;
};

FrameMost most_of(const EncoderConfig& encoder) {
  const StreamConfig& stream = encoder.stream;
  const CameraModel& camera = stream.camera;
  switch (stream.kind) {
    case FrameKind::kPoints: {
      const PointSurfaceOptions search = surface_options(stream, encoder.stages);
      const FrameLimits limits = list_limits(stream, encoder.stages, search);
      return {limits.list_bytes, limits.list_slices};
    }
    case FrameKind::kRawCloud:
      return {raw_frame_capacity(camera.width, camera.height),
              slice_capacity(camera.width, camera.height)};
    case FrameKind::kDepth:
      break;
  }
  return {frame_capacity(camera.width, camera.height), slice_capacity(camera.width, camera.height)};
}

std::vector<std::string> thread_names(const EncoderConfig& encoder) {
  std::vector<std::string> names = {"source", "sender", "publisher"};
  const auto inside = Encoder::thread_names(encoder);
  names.insert(names.begin() + 1, inside.begin(), inside.end());
  return names;
}

}  // namespace

std::size_t frame_bytes(const StreamConfig& config) {
  if (config.kind == FrameKind::kPoints)
    return std::size_t{config.points.max_points} * sizeof(Point3f);
  const std::size_t each =
      config.kind == FrameKind::kRawCloud ? sizeof(Point3f) : sizeof(std::uint16_t);
  return config.camera.pixels() * each;
}

Result<MemoryPlan> plan_memory(const MemoryNeeds& needs) {
  MemoryPlan plan;
  const auto encoder = Encoder::memory_bytes(needs.encoder);
  if (!encoder) return encoder.error();
  plan.encoder = *encoder;
  plan.publisher = Publisher::memory_bytes(needs.publisher);
  plan.preloaded = needs.preloaded_frames * frame_bytes(needs.encoder.stream);
  Arena arena = Arena::measuring();
  lay_out(needs, plan, arena, nullptr);
  (void)arena.take<std::byte>(plan.publisher);
  if (arena.failed())
    return {
        Status::kOutOfArena,
        fmt::format("an encoder of {} bytes and {} frames held decoded ({} bytes) are more than "
                    "this machine can address; hold fewer (--preload), or send smaller frames",
                    plan.encoder, needs.preloaded_frames, plan.preloaded)};
  plan.arena = arena.bytes_needed();
  plan.threads = thread_names(needs.encoder);
  plan.stack = stack_mapping_bytes();
  return plan;
}

Result<DaemonMemory> take_memory(const MemoryNeeds& needs, const MemoryPlan& plan,
                                 ArenaOptions options) {
  auto arena = Arena::map(plan.arena, options);
  if (!arena) return arena.error();
  DaemonMemory memory;
  memory.arena = std::move(*arena);
  lay_out(needs, plan, memory.arena, &memory);
  if (memory.arena.failed())
    return {Status::kOutOfArena, "the memory plan does not cover what it is for"};
  return memory;
}

std::vector<std::string> to_lines(const MemoryPlan& plan, const MemoryNeeds& needs,
                                  std::uint64_t resident) {
  const CameraModel& camera = needs.encoder.stream.camera;
  const StreamConfig& stream = needs.encoder.stream;
  const std::string size = stream.kind == FrameKind::kPoints
                               ? fmt::format("{} points", stream.points.max_points)
                               : fmt::format("{}x{}", camera.width, camera.height);
  const auto line = [](const char* name, std::uint64_t bytes, const std::string& note) {
    return fmt::format("{:<10} {:>12}  {}", name, bytes, note);
  };
  return {
      line("encoder", plan.encoder,
           fmt::format("{} frame slots of {}, tables, the stages' own", needs.encoder.runner.slots,
                       size)),
      line("publisher", plan.publisher,
           fmt::format("{} frame buffers of {} bytes", needs.publisher.frames,
                       needs.publisher.max_frame_bytes)),
      line("preload", plan.preloaded,
           fmt::format("{} input frames held decoded", needs.preloaded_frames)),
      line("arena", plan.arena, "the three above in one mapping, with padding"),
      line("stacks", plan.stacks(),
           fmt::format("{} threads of {} bytes, a guard page in each: {}", plan.threads.size(),
                       plan.stack, fmt::join(plan.threads, ", "))),
      line("rest", resident,
           "resident beside them now: program, libraries, heap; not in the total"),
      line("total", plan.total(), "bytes mapped, arena and stacks"),
  };
}

PublisherConfig publisher_for(const EncoderConfig& encoder, const std::string& channel,
                              std::uint32_t message_bytes) {
  const FrameMost most = most_of(encoder);
  const std::size_t packets = most.slices + 1, payload = most.bytes;
  constexpr std::size_t kKeyBytes = kPacketHeaderBytes + kMaxKeyBodyBytes + kEnvelopeOverheadBytes;
  PublisherConfig config;
  config.channel = channel;
  config.message_bytes = std::max(message_bytes, static_cast<std::uint32_t>(kKeyBytes));
  config.max_packets = static_cast<std::uint32_t>(packets);
  const std::size_t frame = payload + kKeyBytes + packets * kEnvelopeOverheadBytes;
  config.max_frame_bytes = static_cast<std::uint32_t>(
      std::clamp<std::size_t>(frame, config.message_bytes, kMostFrameBytes));
  return config;
}

}  // namespace planecast
