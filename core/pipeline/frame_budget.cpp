#include "core/pipeline/frame_budget.hpp"

#include <time.h>

#include <algorithm>

namespace planecast {
namespace {

// [ns] a pixel, for what has not been measured yet: twice what a server takes, so that the first
// frames rather do less.
constexpr std::int64_t kGuess[kTimedStages][kFrameEfforts] = {
    {8, 6, 0, 0}, {10, 8, 0, 0}, {80, 80, 80, 16}};

// Of a gap between what is expected and less, the share that one frame closes.
constexpr std::int64_t kForget = 8;

// Of what an effort is believed to cost, the share that goes with every frame.
constexpr std::int64_t kAge = 64;

// A plan leaves this share of the budget, in per cent, for frames that cost more than the last.
constexpr std::int64_t kReserve = 10;

}  // namespace

const char* to_string(FrameEffort effort) noexcept {
  switch (effort) {
    case FrameEffort::kFull:
      return "full";
    case FrameEffort::kPlanes:
      return "planes";
    case FrameEffort::kNeighbours:
      return "neighbours";
    case FrameEffort::kRuns:
      return "runs";
  }
  return "unknown";
}

std::int64_t thread_cpu_ns() noexcept {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

void FrameBudget::set(std::int64_t budget_ns, FrameClock clock, std::uint32_t pixels,
                      FrameEffort least) noexcept {
  budget_ns_ = budget_ns;
  clock_ = clock;
  pixels_ = pixels;
  least_ = least;
  for (Costs& costs : learned_) {
    for (auto& cost : costs) cost.store(-1, std::memory_order_relaxed);
  }
}

std::int64_t FrameBudget::expected(TimedStage stage, FrameEffort effort) const noexcept {
  const auto s = static_cast<std::size_t>(stage);
  const auto e = static_cast<std::size_t>(effort);
  const std::int64_t known = learned_[s][e].load(std::memory_order_relaxed);
  if (known >= 0) return known;
  // The nearest effort that has been measured, by the ratio that is usual between the two.
  for (std::size_t other = kFrameEfforts; other-- > 0;) {
    const std::int64_t cost = learned_[s][other].load(std::memory_order_relaxed);
    if (cost < 0 || kGuess[s][other] == 0) continue;
    return cost * kGuess[s][e] / kGuess[s][other];
  }
  return kGuess[s][e] * pixels_;
}

std::int64_t FrameBudget::measured(TimedStage stage, FrameEffort effort) const noexcept {
  const auto& cost = learned_[static_cast<std::size_t>(stage)][static_cast<std::size_t>(effort)];
  return std::max<std::int64_t>(cost.load(std::memory_order_relaxed), 0);
}

FrameEffort FrameBudget::plan(TimedStage stage, FrameEffort current,
                              std::int64_t spent_ns) const noexcept {
  if (!limited()) return current;
  const std::int64_t left = budget_ns_ - budget_ns_ * kReserve / 100 - spent_ns;
  const auto least = static_cast<std::size_t>(least_);
  for (auto e = static_cast<std::size_t>(current); e < least; ++e) {
    std::int64_t cost = 0;
    for (auto s = static_cast<std::size_t>(stage); s < kTimedStages; ++s) {
      cost += expected(static_cast<TimedStage>(s), static_cast<FrameEffort>(e));
    }
    if (cost <= left) return static_cast<FrameEffort>(e);
  }
  return std::max(current, least_);
}

void FrameBudget::learn(TimedStage stage, FrameEffort effort, std::int64_t took_ns) noexcept {
  if (!limited()) return;
  Costs& costs = learned_[static_cast<std::size_t>(stage)];
  for (auto& other : costs) {
    const std::int64_t known = other.load(std::memory_order_relaxed);
    if (known > 0) other.store(known - known / kAge, std::memory_order_relaxed);
  }
  auto& cost = costs[static_cast<std::size_t>(effort)];
  const std::int64_t known = cost.load(std::memory_order_relaxed);
  const bool more = known < 0 || took_ns >= known;
  cost.store(more ? took_ns : known - (known - took_ns) / kForget, std::memory_order_relaxed);
}

}  // namespace planecast
