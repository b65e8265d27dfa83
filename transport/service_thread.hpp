// A thread of transport's own: named, signals left to the main thread, on a stack that is mapped
// whole and present before it starts.
#pragma once

#include <pthread.h>

#include "core/base/status.hpp"
#include "core/base/thread_stack.hpp"

namespace planecast {

/// Used by one thread at a time. Its stack is stack_mapping_bytes() beside all arenas.
class ServiceThread {
 public:
  ServiceThread() noexcept = default;
  ~ServiceThread() { join(); }
  ServiceThread(const ServiceThread&) = delete;
  ServiceThread& operator=(const ServiceThread&) = delete;

  /// Runs entry(argument) after on_start(name), which may be null. kOutOfArena: no stack; kStopped:
  /// no thread; the message names the limit to raise.
  Result<Done> start(const char* name, void (*on_start)(const char* name), void (*entry)(void*),
                     void* argument);

  /// Waits for its end and gives the stack back; nothing happens when it does not run.
  void join() noexcept;

 private:
  static void* run(void* self) noexcept;

  pthread_t thread_{};
  ThreadStack stack_;
  bool running_ = false;
  const char* name_ = "";
  void (*on_start_)(const char* name) = nullptr;
  void (*entry_)(void*) = nullptr;
  void* argument_ = nullptr;
};

}  // namespace planecast
