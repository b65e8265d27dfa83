// Keeps each frame's encoding within a time, by effort: what a frame may still cost is planned from
// what frames before it took. The error bound is never part of it. Stages of one encoder share one.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

namespace planecast {

/// What a frame is coded with, from the most to the least.
enum class FrameEffort : std::uint8_t {
  kFull = 0,        ///< all there is
  kPlanes = 1,      ///< no degree two, no consensus
  kNeighbours = 2,  ///< no surfaces
  kRuns = 3,        ///< tiles that no time is left for are coded by runs
};
inline constexpr std::size_t kFrameEfforts = 4;

/// "full", "planes", "neighbours", "runs".
const char* to_string(FrameEffort effort) noexcept;

/// CPU time of the calling thread [ns].
std::int64_t thread_cpu_ns() noexcept;

/// A clock that stages read [ns]; any origin, never backwards within one thread.
using FrameClock = std::int64_t (*)() noexcept;

/// The stages whose cost depends on the effort.
enum class TimedStage : std::uint8_t { kSegment = 0, kFit = 1, kPack = 2 };
inline constexpr std::size_t kTimedStages = 3;

/// Plans and learns. Any thread; relaxed counters, since a plan may be a frame old.
class FrameBudget {
 public:
  /// `budget_ns` of one frame, 0 = none; `least`: no less effort than this is planned (streams that
  /// drop what lies on no surface need surfaces). Below kNeighbours nothing is planned: the packer
  /// itself goes over to runs where it is late. Call before the stages run.
  void set(std::int64_t budget_ns, FrameClock clock, std::uint32_t pixels,
           FrameEffort least = FrameEffort::kNeighbours) noexcept;

  bool limited() const noexcept { return budget_ns_ > 0; }
  std::int64_t budget_ns() const noexcept { return budget_ns_; }
  std::int64_t now() const noexcept { return clock_(); }
  FrameClock now_function() const noexcept { return clock_; }

  /// The most effort, `current` or less, with which `stage` and those after it are expected to end
  /// in time when `spent_ns` are gone; the least when none is.
  FrameEffort plan(TimedStage stage, FrameEffort current, std::int64_t spent_ns) const noexcept;

  /// What a stage took: large figures count at once, small ones by and by. What was not tried is
  /// believed to get cheaper with every frame, so that it is tried again.
  void learn(TimedStage stage, FrameEffort effort, std::int64_t took_ns) noexcept;

  /// What a stage is expected to take [ns]; of one never measured, a cautious guess.
  std::int64_t expected(TimedStage stage, FrameEffort effort) const noexcept;

  /// What a stage took lately [ns], 0 = never measured.
  std::int64_t measured(TimedStage stage, FrameEffort effort) const noexcept;

 private:
  using Costs = std::array<std::atomic<std::int64_t>, kFrameEfforts>;

  std::int64_t budget_ns_ = 0;
  FrameClock clock_ = thread_cpu_ns;
  std::uint32_t pixels_ = 0;
  FrameEffort least_ = FrameEffort::kNeighbours;
  std::array<Costs, kTimedStages> learned_{};
};

}  // namespace planecast
