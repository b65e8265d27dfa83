// A thread as the pipeline wants it: named, signals left to the main thread, stack present, and
// real-time scheduling or a core of its own where the machine allows. The only use of pthread here.
#pragma once

#include <pthread.h>

#include <cstdint>

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

/// Creates a joinable thread with all asynchronous signals blocked, so that SIGTERM and friends
/// reach the threads that expect them. Returns 0 or the errno of pthread_create.
int create_worker(pthread_t& thread, void* (*entry)(void*), void* argument) noexcept;

/// Dresses the calling thread; what is refused is told, never fatal. Also touches 256 kB of stack,
/// so that the first frame meets no page fault.
ThreadRefusals prepare_worker(const ThreadWishes& wishes) noexcept;

/// Polling time that suits `threads` busy threads: 20 us when there is a core for each and one
/// more, else 0, because pollers would then take the core from the thread they wait for.
std::uint32_t suitable_spin_ns(std::uint32_t threads) noexcept;

}  // namespace planecast
