// SIGINT, SIGTERM and SIGHUP as something to wait for instead of handlers: blocked in every thread
// that starts later, taken by the main thread.
#pragma once

#include <csignal>
#include <cstdint>

namespace planecast {

class StopSignals {
 public:
  /// Blocks the signals in the calling thread; before any other thread is started.
  StopSignals() noexcept;

  /// Waits up to `timeout_ns`; true once a signal has come, at once from then on. Main thread.
  bool wait(std::int64_t timeout_ns) noexcept;

  /// The same without waiting.
  bool asked() noexcept { return wait(0); }

  /// The signal that came, 0 before.
  int signal() const noexcept { return signal_; }

 private:
  sigset_t set_;
  int signal_ = 0;
};

}  // namespace planecast
