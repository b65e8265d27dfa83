// A thread as the pipeline wants it: named, signals left to the main thread, on a stack of its own
// that is present from the start, and with real-time scheduling or a core of its own where the
// machine allows.
#pragma once

#include <pthread.h>

#include <cstdint>

#include "core/base/thread_stack.hpp"

namespace planecast {

/// Wishes for the calling thread, as in RunnerConfig.
struct ThreadWishes {
  const char* name = "";  ///< cut to 15 characters
  int fifo_priority = 0;  ///< SCHED_FIFO priority; 0: leave the scheduler alone
  int core = -1;          ///< index among the cores that the process may use, modulo; -1: any
};

/// Which wishes the system did not grant.
struct ThreadRefusals {
  bool fifo = false;
  bool affinity = false;
};

/// One thread on a stack of stack_mapping_bytes(). Trivial, so that it may lie in an arena: whoever
/// starts it joins it. Used by one thread at a time.
struct WorkerThread {
  pthread_t thread{};
  ThreadStack stack;
  bool running = false;

  /// Runs entry(argument) with all asynchronous signals blocked, so that SIGTERM and friends reach
  /// the threads that expect them. Returns 0, or the errno of mmap or pthread_create.
  int start(void* (*entry)(void*), void* argument) noexcept;

  /// Waits for its end and gives the stack back; nothing happens when it was not started.
  void join() noexcept;
};

/// Dresses the calling thread; what is refused is told, never fatal. The name comes last: whoever
/// sees it sees a thread that is ready.
ThreadRefusals prepare_worker(const ThreadWishes& wishes) noexcept;

/// Polling time that suits `threads` busy threads: 20 us when there is a core for each and one
/// more, else 0, because pollers would then take the core from the thread they wait for.
std::uint32_t suitable_spin_ns(std::uint32_t threads) noexcept;

}  // namespace planecast
