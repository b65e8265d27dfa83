#include "transport/assembler.hpp"

#include <algorithm>
#include <atomic>
#include <string>
#include <vector>

#include "transport/snapshot_box.hpp"
#include "transport/stream_assembler.hpp"
#include "transport/wake.hpp"

namespace planecast {
namespace {

std::string config_mistake(const AssemblerConfig& config) {
  if (config.max_streams < 1 || config.max_streams > kMaxStreams)
    return "max_streams must be 1 to " + std::to_string(kMaxStreams);
  if (config.max_slices < 1 || config.max_slices > 65'535) return "max_slices must be 1 to 65535";
  if (config.max_frame_bytes < 1 || config.max_frame_bytes > (1U << 30U))
    return "max_frame_bytes must be 1 byte to 1 GiB";
  if (config.max_key_bytes > (1U << 20U)) return "max_key_bytes must be at most 1 MiB";
  if (config.frame_bits < 16 || config.frame_bits > 32) return "frame_bits must be 16 to 32";
  if (config.frames_in_assembly < 1 || config.frames_in_assembly > StreamAssembler::kMaxInAssembly)
    return "frames_in_assembly must be 1 to 8";
  if (config.output_frames < 1 || config.output_frames > 256)
    return "output_frames must be 1 to 256";
  if (config.held_frames < 1 || config.held_frames > 256) return "held_frames must be 1 to 256";
  if (config.deadline_ns < 0 || config.session_timeout_ns < 0)
    return "deadline and session timeout must not be negative";
  return {};
}

}  // namespace

struct Assembler::Impl {
  AssemblerConfig config;
  Arena own_arena;
  std::vector<StreamAssembler> streams;
  std::atomic<std::uint16_t> stream_count{0};
  LinkStatistics link;
  SnapshotBox<LinkStatistics> link_box;
  Wake wake;
  std::atomic<bool> interrupted{false};
  std::uint16_t next_turn = 0;  // the consumer's

  StreamAssembler* stream_of(std::uint16_t stream) noexcept;
};

// Streams are told apart in the order they are first heard; the count is published after the
// entry is ready, so the other threads see it whole.
StreamAssembler* Assembler::Impl::stream_of(std::uint16_t stream) noexcept {
  const std::uint16_t count = stream_count.load(std::memory_order_acquire);
  for (std::uint16_t i = 0; i < count; ++i)
    if (streams[i].stream() == stream) return &streams[i];
  return nullptr;
}

Assembler::Assembler(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

Assembler::~Assembler() = default;

std::size_t Assembler::memory_bytes(const AssemblerConfig& config) noexcept {
  Arena arena = Arena::measuring();
  StreamAssembler stream;
  for (std::uint16_t i = 0; i < config.max_streams; ++i) stream.lay_out(config, arena);
  return arena.bytes_needed();
}

Result<std::unique_ptr<Assembler>> Assembler::create(const AssemblerConfig& config, Arena* arena) {
  std::string mistake = config_mistake(config);
  if (!mistake.empty()) return {Status::kBadConfig, "receiver: " + mistake};
  auto impl = std::make_unique<Impl>();
  impl->config = config;
  if (arena == nullptr) {
    Result<Arena> mapped = Arena::map(memory_bytes(config));
    if (!mapped) return mapped.error();
    impl->own_arena = std::move(*mapped);
    arena = &impl->own_arena;
  }
  impl->streams = std::vector<StreamAssembler>(config.max_streams);
  for (StreamAssembler& stream : impl->streams) stream.lay_out(config, *arena);
  if (arena->failed())
    return {Status::kOutOfArena, "the receiver needs " + std::to_string(memory_bytes(config)) +
                                     " bytes, more than the arena has left"};
  return std::unique_ptr<Assembler>(new Assembler(std::move(impl)));
}

void Assembler::push(std::span<const std::uint8_t> packet, const PacketInfo& info,
                     std::int64_t now_ns) noexcept {
  Impl& impl = *impl_;
  if (packet.empty() || (!info.key && info.slice >= info.slice_count)) {
    impl.link.count_refused(Status::kFieldRange);
    publish_link();
    return;
  }
  StreamAssembler* stream = impl.stream_of(info.stream);
  if (stream == nullptr) {
    const std::uint16_t count = impl.stream_count.load(std::memory_order_relaxed);
    if (count == impl.config.max_streams) {
      ++impl.link.unknown_stream;
      publish_link();
      return;
    }
    stream = &impl.streams[count];
    stream->begin(info.stream);
    impl.stream_count.store(static_cast<std::uint16_t>(count + 1), std::memory_order_release);
  }
  if (stream->push(packet, info, now_ns)) impl.wake.notify();
}

void Assembler::poll(std::int64_t now_ns) noexcept {
  Impl& impl = *impl_;
  const std::uint16_t count = impl.stream_count.load(std::memory_order_relaxed);
  bool any = false;
  for (std::uint16_t i = 0; i < count; ++i) any = impl.streams[i].poll(now_ns) || any;
  if (any) impl.wake.notify();
}

std::int64_t Assembler::next_deadline_ns() const noexcept {
  std::int64_t next = std::numeric_limits<std::int64_t>::max();
  const std::uint16_t count = impl_->stream_count.load(std::memory_order_relaxed);
  for (std::uint16_t i = 0; i < count; ++i)
    next = std::min(next, impl_->streams[i].next_deadline_ns());
  return next;
}

LinkStatistics& Assembler::link() noexcept {
  return impl_->link;
}

void Assembler::publish_link() noexcept {
  impl_->link_box.store(impl_->link);
}

FrameRef Assembler::take() noexcept {
  Impl& impl = *impl_;
  const std::uint16_t count = impl.stream_count.load(std::memory_order_acquire);
  for (std::uint16_t i = 0; i < count; ++i) {
    const auto turn = static_cast<std::uint16_t>((impl.next_turn + i) % count);
    if (FrameRef frame = impl.streams[turn].take()) {
      impl.next_turn = static_cast<std::uint16_t>((turn + 1) % count);
      return frame;
    }
  }
  return {};
}

FrameRef Assembler::take(std::uint16_t stream) noexcept {
  StreamAssembler* found = impl_->stream_of(stream);
  return found == nullptr ? FrameRef() : found->take();
}

FrameRef Assembler::wait(std::int64_t timeout_ns) noexcept {
  Impl& impl = *impl_;
  const std::int64_t limit_ns = monotonic_ns() + timeout_ns;
  for (;;) {
    if (FrameRef frame = take()) return frame;
    if (impl.interrupted.exchange(false, std::memory_order_acq_rel)) return {};
    if (!impl.wake.wait_until(limit_ns)) return take();
  }
}

void Assembler::count_unknown_keys(std::uint16_t stream, std::uint64_t slices) noexcept {
  StreamAssembler* found = impl_->stream_of(stream);
  if (found != nullptr) found->count_unknown_keys(slices);
}

void Assembler::interrupt() noexcept {
  impl_->interrupted.store(true, std::memory_order_release);
  impl_->wake.notify();
}

ReceiverStatistics Assembler::statistics() const noexcept {
  ReceiverStatistics out;
  impl_->link_box.load(out.link);
  out.stream_count = impl_->stream_count.load(std::memory_order_acquire);
  for (std::uint16_t i = 0; i < out.stream_count; ++i) impl_->streams[i].snapshot(out.streams[i]);
  return out;
}

}  // namespace planecast
