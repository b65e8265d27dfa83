// Runs a chain of stages over frame slots, on the caller's thread or one thread per stage, from the
// same stage objects. Slots stay, handles move: source -> stage ... stage -> done -> back to
// source. Every ring holds all handles, so a push cannot fail; the only drop point is claim().
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "core/base/arena.hpp"
#include "core/base/status.hpp"
#include "core/pipeline/frame_team.hpp"
#include "core/pipeline/stage.hpp"
#include "core/pipeline/stage_stats.hpp"

namespace planecast {

enum class RunMode : std::uint8_t {
  kInline,   ///< submit() runs all stages itself: deterministic, no threads
  kThreads,  ///< one worker thread per stage
};

enum class StopMode : std::uint8_t {
  kDrain,    ///< frames in flight are processed
  kDiscard,  ///< frames in flight skip the stages they have not begun, with status kStopped
};

struct RunnerConfig {
  std::uint32_t slots = 6;  ///< frames in flight at most, 1..SlotPool::kMaxSlots
  RunMode mode = RunMode::kThreads;
  std::int64_t spin_ns =
      -1;  ///< polling before sleep [ns], 0..1e9; -1: 20 us if each thread has a core, else 0
  int fifo_priority = 0;  ///< SCHED_FIFO priority 1..99; 0: the ordinary scheduler
  int first_core = -1;    ///< stage i runs on the (first_core + i)-th core allowed; -1: anywhere
  std::int64_t deadline_ns = 0;  ///< a frame longer in one stage counts as late; 0: none does
  void (*on_thread_start)(const char* name) =
      nullptr;  ///< called in each worker before its first frame
  void (*on_thread_stop)(const char* name) =
      nullptr;  ///< called in each worker after its last frame
};

/// Every frame that the source asked a slot for: in = ok + failed + dropped + those in flight.
struct FrameTotals {
  std::uint64_t in = 0;
  std::uint64_t ok = 0;       ///< reached the done ring with kOk
  std::uint64_t failed = 0;   ///< reached the done ring with another status
  std::uint64_t dropped = 0;  ///< got no slot, or were refused because the runner was stopped
  std::uint64_t in_flight() const noexcept { return in - ok - failed - dropped; }
};

/// The chain. Three roles, each one thread at a time (all may be the same thread): the source calls
/// claim*() and submit(), the consumer pop_done*(), status() and release(), the control thread
/// init(), start() and stop(). start() and stop() may be called by any threads but never from
/// inside a stage. Statistics may be read by anyone. Only init() takes memory (from the arena) and
/// only start() uses system resources; the arena and the stages must outlive the runner.
class StageRunner {
 public:
  static constexpr std::uint32_t kMaxStages = 8;

  StageRunner() noexcept = default;
  ~StageRunner();  ///< stops; frames still in flight are discarded
  StageRunner(const StageRunner&) = delete;
  StageRunner& operator=(const StageRunner&) = delete;

  /// Bytes that init() takes from an empty arena, exactly; 0 for a bad configuration.
  static std::size_t memory_bytes(const RunnerConfig& config, std::size_t stage_count) noexcept;

  /// Bytes that start() maps for the stages' stacks beside the arena, exactly; stop() gives them
  /// back.
  static std::size_t stack_bytes(const RunnerConfig& config, std::size_t stage_count) noexcept;

  /// Lays the runner out for 1..kMaxStages stages, once. Over a measuring arena it only counts and
  /// the runner stays unusable. Returns kBadConfig, kOutOfArena, or kOk.
  Status init(Arena& arena, const RunnerConfig& config, std::span<const StageRef> stages) noexcept;

  /// After init() and before the first start(): `team`, which must outlive the runner, helps the
  /// last stage; start() and stop() include its thread, called `name`, on the core of the stage
  /// before, which is done with the frame by then. Nothing in inline mode.
  void share(FrameTeam& team, const char* name) noexcept;

  /// Starts the worker threads and returns when all are ready; nothing happens when running
  /// already. Fails with kBadConfig before init(), with kStopped when a thread cannot be created
  /// (the others are ended first). May follow stop(); counters go on from where they were.
  Result<Done> start();

  /// Ends the workers and returns when they are gone; all frames submitted are then in the done
  /// ring. Never waits for the consumer. Nothing happens when stopped already.
  void stop(StopMode mode = StopMode::kDrain) noexcept;

  bool running() const noexcept;

  /// Source: a slot for a new frame; none = the frame is dropped. Never blocks.
  std::optional<std::uint32_t> claim() noexcept;

  /// Source that must lose nothing: waits for a slot; none only once stopped. In inline mode the
  /// consumer must be another thread. Allowed before start().
  std::optional<std::uint32_t> claim_wait() noexcept;

  /// Source: sends a claimed and filled slot on its way; with a status other than kOk it flows past
  /// the stages and counts as failed. Returns kStopped when not running: the handle is then given
  /// back and the frame counts as dropped. Inline mode runs all stages before it returns.
  Status submit(std::uint32_t handle, Status status = Status::kOk) noexcept;

  /// Consumer: the next frame that went through, in the order of submit(); false when there is
  /// none.
  [[nodiscard]] bool try_pop_done(std::uint32_t& handle) noexcept;

  /// Consumer: waits for it; false once the runner is stopped and all frames were taken. Waits also
  /// before the first start().
  [[nodiscard]] bool pop_done(std::uint32_t& handle) noexcept;

  /// Consumer: outcome of a frame between pop_done() and release().
  Status status(std::uint32_t handle) const noexcept;

  /// Consumer: gives the slot back; false, with nothing changed, when it was given back already.
  bool release(std::uint32_t handle) noexcept;

  /// Anyone: exact while no frame moves, else at most one frame off per role.
  FrameTotals totals() const noexcept;

  std::uint32_t stage_count() const noexcept;

  /// Anyone: counters of stage i < stage_count(). O(histogram), for once a second, not once a
  /// frame.
  StageReport report(std::uint32_t i) const noexcept;

  /// Watchdog: the stage has a frame in work or waiting and gave no sign of life for `limit_ns`.
  bool stalled(std::uint32_t i, std::int64_t limit_ns) const noexcept;

  /// True when SCHED_FIFO or the choice of core was asked for and refused; valid after start().
  bool fifo_refused() const noexcept;
  bool affinity_refused() const noexcept;

 private:
  struct Core;  ///< rings, counters, threads; lives in the arena
  Core* core_ = nullptr;
};

}  // namespace planecast
