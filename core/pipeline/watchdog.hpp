// Looks at the stages' heartbeats from outside and tells which fell silent with work in hand or
// waiting: a stage that hangs never gets to count itself late.
#pragma once

#include <array>
#include <cstdint>

#include "core/pipeline/stage_runner.hpp"

namespace planecast {

class Watchdog {
 public:
  /// A stage is silent when it gave no sign of life for `limit_ns` > 0 though it had work. The
  /// runner must outlive the watchdog.
  Watchdog(const StageRunner& runner, std::int64_t limit_ns) noexcept
      : runner_(runner), limit_ns_(limit_ns) {}

  /// Looks once: bit i is set when stage i has fallen silent since the last look. One thread, that
  /// is none of the pipeline's; a few times within the limit. Never blocks. O(stages).
  std::uint32_t look() noexcept {
    std::uint32_t fell = 0;
    for (std::uint32_t i = 0; i < runner_.stage_count(); ++i) {
      const bool silent = runner_.stalled(i, limit_ns_);
      if (silent && !silent_[i]) {
        fell |= 1U << i;
        ++silences_[i];
      }
      silent_[i] = silent;
    }
    return fell;
  }

  /// Times that stage i fell silent.
  std::uint64_t silences(std::uint32_t i) const noexcept { return silences_[i]; }

  std::int64_t limit_ns() const noexcept { return limit_ns_; }

 private:
  const StageRunner& runner_;
  std::int64_t limit_ns_;
  std::array<bool, StageRunner::kMaxStages> silent_{};
  std::array<std::uint64_t, StageRunner::kMaxStages> silences_{};
};

}  // namespace planecast
