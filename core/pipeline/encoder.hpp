// The encoder of one stream: fixed memory, four stages, on the caller's thread or one worker each.
//   auto encoder = Encoder::create(config);            // all memory, nothing after
//   (*encoder)->start();
//   (*encoder)->submit(frame);                         // source thread; never blocks
//   while ((*encoder)->next(packed)) { ...; (*encoder)->release(packed); }  // consumer thread
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/base/arena.hpp"
#include "core/pipeline/frame_slot.hpp"
#include "core/pipeline/frame_team.hpp"
#include "core/pipeline/stage_runner.hpp"
#include "core/pipeline/stages.hpp"

namespace planecast {

/// Everything that must be known before memory is taken.
struct EncoderConfig {
  StreamConfig stream;
  StageOptions stages;
  RunnerConfig runner;
  ArenaOptions memory;
  double budget_ms = 0;              ///< CPU time of one frame over all stages; 0 = no limit
  FrameClock clock = thread_cpu_ns;  ///< what the budget is measured by
  std::uint32_t pack_threads = 2;    ///< that share the packing of a depth frame, 1 or 2; with
                                     ///< RunMode::kThreads and no budget, else it is one
};

/// A depth image to encode; not owned, copied by submit().
struct DepthView {
  std::span<const std::uint16_t> depth;  ///< row-major, width * height of the stream's camera
  std::uint64_t number = 0;
  std::int64_t stamp_ns = 0;  ///< capture time on the stream's clock
};

/// A finished frame, valid until release(). status: kOk, or why it carries no slices.
struct EncodedFrame {
  Status status = Status::kOk;
  const FrameSlot* slot = nullptr;
  std::uint32_t handle = 0;
};

class Encoder {
 public:
  /// Exact bytes that create() maps for this configuration. kBadConfig, kFieldRange.
  static Result<std::size_t> memory_bytes(const EncoderConfig& config);

  /// Takes all memory: maps it, or uses `memory` (the caller's, 64-byte aligned, memory_bytes()
  /// long, to outlive the encoder). Errors name the setting.
  static Result<std::unique_ptr<Encoder>> create(const EncoderConfig& config,
                                                 std::span<std::byte> memory = {});
  ~Encoder();
  Encoder(const Encoder&) = delete;
  Encoder& operator=(const Encoder&) = delete;

  /// Bytes that start() maps for the stacks of its threads beside the arena, exactly.
  static std::size_t stack_bytes(const EncoderConfig& config) noexcept;
  /// Names of the threads that start() starts, in order.
  static std::vector<const char*> thread_names(const EncoderConfig& config);

  Result<Done> start() { return runner_.start(); }
  void stop(StopMode mode = StopMode::kDrain) noexcept { runner_.stop(mode); }

  /// Source thread: copies a frame in. kNoSlot: every slot is in use, the frame is dropped and
  /// counted; kWrongSize; kStopped. No allocation. `wait` waits for a slot instead of dropping.
  Status submit(const DepthView& frame, bool wait = false) noexcept;
  /// The same for a raw-cloud stream: width * height points, NaN = no reading. For a stream of
  /// points: any number up to max_points, else kFrameTooLarge; those that are not finite are none.
  Status submit(std::span<const Point3f> points, std::uint64_t number, std::int64_t stamp_ns,
                bool wait = false) noexcept;

  /// Consumer thread: the next finished frame, in order of submit(). next() waits and returns false
  /// once stopped and empty; try_next() never waits.
  bool next(EncodedFrame& out) noexcept;
  bool try_next(EncodedFrame& out) noexcept;
  void release(const EncodedFrame& frame) noexcept { (void)runner_.release(frame.handle); }

  /// The sealed key packet for a frame, written to `out` (kPacketHeaderBytes + kMaxKeyBodyBytes);
  /// returns its size.
  std::size_t key_packet(std::uint64_t frame, std::int64_t stamp_ns,
                         std::span<std::uint8_t> out) const noexcept;

  const StreamTables& tables() const noexcept { return tables_; }
  const EncoderConfig& config() const noexcept { return config_; }
  const StageRunner& runner() const noexcept { return runner_; }
  std::size_t memory_in_use() const noexcept { return arena_.bytes_used(); }

 private:
  explicit Encoder(const EncoderConfig& config) : config_(config) {}
  Status layout(Arena& arena) noexcept;
  Status check_size(std::size_t points) const noexcept;
  EncodedFrame finished(std::uint32_t handle) noexcept;

  EncoderConfig config_;
  Arena arena_;
  StreamTables tables_;
  FrameBudget budget_;
  std::span<FrameSlot> slots_;
  FilterStage filter_;
  SegmentStage segment_;
  FitStage fit_;
  PackStage pack_;
  std::span<std::uint8_t> key_body_;
  std::size_t key_body_bytes_ = 0;
  FrameTeam team_;
  StageRunner runner_;
};

}  // namespace planecast
