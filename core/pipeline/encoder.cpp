#include "core/pipeline/encoder.hpp"

#include <algorithm>

#include "core/ring/slot_pool.hpp"
#include "core/wire/key_packet.hpp"
#include "core/wire/point_pack.hpp"

namespace planecast {
namespace {

constexpr std::size_t kStages = 4;
constexpr const char* kHelper = "pack2";

bool helped(const EncoderConfig& config) noexcept {
  return config.pack_threads > 1 && config.runner.mode == RunMode::kThreads &&
         config.stream.kind == FrameKind::kDepth && !(config.budget_ms > 0);
}

FrameLimits limits_of(const EncoderConfig& config, const PointSurfaceOptions& search) {
  if (config.stream.kind == FrameKind::kPoints)
    return list_limits(config.stream, config.stages, search);
  return {config.stream.camera.width, config.stream.camera.height};
}

std::size_t least_slice_bytes(FrameKind kind) {
  switch (kind) {
    case FrameKind::kDepth:
      return kMinSliceBytes;
    case FrameKind::kRawCloud:
      return kMinRawSliceBytes;
    case FrameKind::kPoints:
      break;
  }
  return kMinPointSliceBytes;
}

Result<Done> check(const EncoderConfig& config) {
  if (const Status status = check_config(config.stream); status != Status::kOk) {
    return Error{status,
                 "the stream's configuration holds a value outside its range; check the "
                 "camera, the depth lattice, the noise model and the tolerance"};
  }
  const StreamConfig& stream = config.stream;
  const bool in_sigmas =
      stream.tolerance == ToleranceKind::kSigma || stream.tolerance == ToleranceKind::kSurfaces;
  if (in_sigmas && stream.noise.kind == NoiseModel::Kind::kUnknown) {
    return Error{Status::kBadConfig, "a tolerance in sigmas needs a noise model"};
  }
  const std::size_t least = least_slice_bytes(config.stream.kind);
  if (config.stages.slice_bytes < least || config.stages.slice_bytes > kFileSliceBytes) {
    return Error{Status::kBadConfig, "slices of this stream have " + std::to_string(least) +
                                         " to " + std::to_string(kFileSliceBytes) + " bytes, not " +
                                         std::to_string(config.stages.slice_bytes)};
  }
  if (config.stages.neighbours < 3 || config.stages.neighbours > kMaxNeighbours) {
    return Error{Status::kBadConfig, "points have 3 to " + std::to_string(kMaxNeighbours) +
                                         " neighbours, not " +
                                         std::to_string(config.stages.neighbours)};
  }
  if (config.pack_threads < 1 || config.pack_threads > kMaxTeamWorkers) {
    return Error{Status::kBadConfig, "a frame is packed by 1 or 2 threads"};
  }
  if (config.stages.range_min > config.stages.range_max) {
    return Error{Status::kBadConfig, "the range's minimum lies above its maximum"};
  }
  // Before the layout, which visits every slot.
  if (StageRunner::memory_bytes(config.runner, kStages) == 0) {
    return Error{Status::kBadConfig, "the pipeline needs 1 to " +
                                         std::to_string(SlotPool::kMaxSlots) +
                                         " slots, a spin time up to 1 s and a priority up to 99"};
  }
  return Done{};
}

}  // namespace

Encoder::~Encoder() {
  runner_.stop(StopMode::kDiscard);
}

std::size_t Encoder::stack_bytes(const EncoderConfig& config) noexcept {
  return StageRunner::stack_bytes(config.runner, kStages) +
         (helped(config) ? stack_mapping_bytes() : 0);
}

std::vector<const char*> Encoder::thread_names(const EncoderConfig& config) {
  if (config.runner.mode != RunMode::kThreads) return {};
  std::vector<const char*> names = {FilterStage::kName, SegmentStage::kName, FitStage::kName,
                                    PackStage::kName};
  if (helped(config)) names.push_back(kHelper);
  return names;
}

Status Encoder::layout(Arena& arena) noexcept {
  const PointSurfaceOptions search = surface_options(config_.stream, config_.stages);
  const FrameLimits limits = limits_of(config_, search);
  tables_.layout(arena, limits);
  filter_.layout(arena, limits, config_.stream.kind);
  segment_.layout(arena, limits, config_.stream.kind);
  fit_.layout(arena, limits, config_.stream.kind);
  pack_.layout(arena, limits, config_.stream.kind, helped(config_) ? kMaxTeamWorkers : 1);
  key_body_ = arena.take<std::uint8_t>(kMaxKeyBodyBytes);
  slots_ = arena.take<FrameSlot>(config_.runner.slots);
  for (std::uint32_t i = 0; i < config_.runner.slots; ++i) {
    FrameSlot measured;
    (slots_.empty() ? measured : slots_[i]).layout(arena, limits, config_.stream.kind);
  }
  const StageRef stages[kStages] = {make_stage_ref(filter_, slots_),
                                    make_stage_ref(segment_, slots_), make_stage_ref(fit_, slots_),
                                    make_stage_ref(pack_, slots_)};
  return runner_.init(arena, config_.runner, stages);
}

Result<std::size_t> Encoder::memory_bytes(const EncoderConfig& config) {
  if (const auto checked = check(config); !checked.ok()) return checked.error();
  Arena arena = Arena::measuring();
  Encoder encoder(config);
  if (const Status status = encoder.layout(arena); status != Status::kOk) {
    return Error{status, "the pipeline cannot be laid out"};
  }
  return arena.bytes_needed();
}

Result<std::unique_ptr<Encoder>> Encoder::create(const EncoderConfig& config,
                                                 std::span<std::byte> memory) {
  const auto bytes = memory_bytes(config);
  if (!bytes.ok()) return bytes.error();
  if (!memory.empty() && memory.size() < *bytes) {
    return Error{Status::kOutOfArena,
                 "the encoder needs " + std::to_string(*bytes) + " bytes of memory"};
  }
  std::unique_ptr<Encoder> encoder(new Encoder(config));
  auto arena = memory.empty() ? Arena::map(*bytes, config.memory) : Arena::over(memory);
  if (!arena.ok()) return arena.error();
  encoder->arena_ = std::move(*arena);
  if (const Status status = encoder->layout(encoder->arena_); status != Status::kOk) {
    return Error{status, "the pipeline's memory could not be laid out"};
  }
  encoder->arena_.seal();
  encoder->key_body_bytes_ = write_key_body(config.stream, encoder->key_body_);
  const Status status = encoder->tables_.build(
      config.stream, key_hash(encoder->key_body_.first(encoder->key_body_bytes_)));
  if (status != Status::kOk) {
    return Error{
        status,
        "the camera's distortion cannot be undone over the whole image; check the coefficients"};
  }
  // What drops all that lies on no surface must look for surfaces, whatever the time.
  encoder->budget_.set(
      static_cast<std::int64_t>(config.budget_ms * 1e6), config.clock,
      config.stream.camera.pixels(),
      config.stream.drop_off_surface ? FrameEffort::kPlanes : FrameEffort::kNeighbours);
  StageOptions options = config.stages;
  options.budget = &encoder->budget_;
  if (helped(config)) {
    options.team = encoder->team_.work();
    encoder->runner_.share(encoder->team_, kHelper);
  }
  encoder->filter_.bind(encoder->tables_, options);
  encoder->segment_.bind(encoder->tables_, options);
  encoder->fit_.bind(encoder->tables_, options);
  encoder->pack_.bind(encoder->tables_, options);
  return encoder;
}

Status Encoder::submit(const DepthView& frame, bool wait) noexcept {
  if (config_.stream.kind != FrameKind::kDepth ||
      frame.depth.size() != config_.stream.camera.pixels()) {
    return Status::kWrongSize;
  }
  const auto handle = wait ? runner_.claim_wait() : runner_.claim();
  if (!handle) return runner_.running() ? Status::kNoSlot : Status::kStopped;
  FrameSlot& slot = slots_[*handle];
  slot.begin(frame.number, frame.stamp_ns, steady_now_ns());
  std::copy(frame.depth.begin(), frame.depth.end(), slot.depth.begin());
  return runner_.submit(*handle);
}

Status Encoder::check_size(std::size_t points) const noexcept {
  switch (config_.stream.kind) {
    case FrameKind::kDepth:
      break;
    case FrameKind::kRawCloud:
      return points == config_.stream.camera.pixels() ? Status::kOk : Status::kWrongSize;
    case FrameKind::kPoints:
      return points <= config_.stream.points.max_points ? Status::kOk : Status::kFrameTooLarge;
  }
  return Status::kWrongSize;
}

Status Encoder::submit(std::span<const Point3f> points, std::uint64_t number, std::int64_t stamp_ns,
                       bool wait) noexcept {
  if (const Status status = check_size(points.size()); status != Status::kOk) return status;
  const auto handle = wait ? runner_.claim_wait() : runner_.claim();
  if (!handle) return runner_.running() ? Status::kNoSlot : Status::kStopped;
  FrameSlot& slot = slots_[*handle];
  slot.begin(number, stamp_ns, steady_now_ns());
  slot.listed = static_cast<std::uint32_t>(points.size());
  std::copy(points.begin(), points.end(), slot.points.begin());
  return runner_.submit(*handle);
}

EncodedFrame Encoder::finished(std::uint32_t handle) noexcept {
  return {runner_.status(handle), &slots_[handle], handle};
}

bool Encoder::next(EncodedFrame& out) noexcept {
  std::uint32_t handle = 0;
  if (!runner_.pop_done(handle)) return false;
  out = finished(handle);
  return true;
}

bool Encoder::try_next(EncodedFrame& out) noexcept {
  std::uint32_t handle = 0;
  if (!runner_.try_pop_done(handle)) return false;
  out = finished(handle);
  return true;
}

std::size_t Encoder::key_packet(std::uint64_t frame, std::int64_t stamp_ns,
                                std::span<std::uint8_t> out) const noexcept {
  const std::size_t bytes = kPacketHeaderBytes + key_body_bytes_;
  if (out.size() < bytes) return 0;
  std::copy_n(key_body_.begin(), key_body_bytes_, out.begin() + kPacketHeaderBytes);
  PacketHeader header;
  header.key = true;
  header.stream = config_.stream.stream;
  header.frame = static_cast<std::uint32_t>(frame) & kFrameNumberMask;
  header.stamp_offset = stamp_offset(stamp_ns, config_.stream.epoch_ns);
  header.key_hash = tables_.key_hash();
  seal_packet(header, out.first(bytes));
  return bytes;
}

}  // namespace planecast
