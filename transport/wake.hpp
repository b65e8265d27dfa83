// One thread waits, another wakes it: a semaphore that holds at most one wake.
// notify() never blocks and makes a system call only when no wake is pending.
#pragma once

#include <semaphore.h>

#include <atomic>
#include <cerrno>
#include <cstdint>
#include <ctime>

namespace planecast {

/// Nanoseconds of the monotonic clock.
inline std::int64_t monotonic_ns() noexcept {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<std::int64_t>(now.tv_sec) * 1'000'000'000 + now.tv_nsec;
}

inline timespec to_timespec(std::int64_t ns) noexcept {
  return {static_cast<std::time_t>(ns / 1'000'000'000), static_cast<long>(ns % 1'000'000'000)};
}

class Wake {
 public:
  Wake() noexcept { ::sem_init(&semaphore_, 0, 0); }
  ~Wake() { ::sem_destroy(&semaphore_); }
  Wake(const Wake&) = delete;
  Wake& operator=(const Wake&) = delete;

  /// Any thread; what was written before is seen by the waiter after wait().
  void notify() noexcept {
    if (!pending_.exchange(true, std::memory_order_acq_rel)) ::sem_post(&semaphore_);
  }

  /// Waits for a wake until `deadline_ns` of the monotonic clock; false when none came.
  bool wait_until(std::int64_t deadline_ns) noexcept {
    const timespec deadline = to_timespec(deadline_ns > 0 ? deadline_ns : 0);
    int status = 0;
    do {
      status = ::sem_clockwait(&semaphore_, CLOCK_MONOTONIC, &deadline);
    } while (status != 0 && errno == EINTR);
    if (status != 0) return false;
    pending_.exchange(false, std::memory_order_acq_rel);
    return true;
  }

 private:
  sem_t semaphore_{};
  std::atomic<bool> pending_{false};
};

}  // namespace planecast
