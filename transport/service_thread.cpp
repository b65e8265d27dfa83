#include "transport/service_thread.hpp"

#include <cerrno>
#include <cstring>

namespace planecast {

void* ServiceThread::run(void* self) noexcept {
  const auto& thread = *static_cast<ServiceThread*>(self);
  if (thread.on_start_ != nullptr) thread.on_start_(thread.name_);
  // Last: whoever sees the name sees a thread that is ready.
  pthread_setname_np(pthread_self(), thread.name_);
  thread.entry_(thread.argument_);
  return nullptr;
}

Result<Done> ServiceThread::start(const char* name, void (*on_start)(const char* name),
                                  void (*entry)(void*), void* argument) {
  name_ = name;
  on_start_ = on_start;
  entry_ = entry;
  argument_ = argument;
  stack_ = map_stack();
  if (stack_.mapping == nullptr) {
    return {Status::kOutOfArena, std::string("the system refuses a stack for the thread '") + name +
                                     "' (" + std::strerror(errno) +
                                     "); raise the limits of memory (ulimit -v, ulimit -l)"};
  }
  const int error = start_on_stack(stack_, &ServiceThread::run, this, thread_);
  running_ = error == 0;
  if (running_) return Done{};
  unmap_stack(stack_);
  return {Status::kStopped, std::string("the system refuses the thread '") + name + "' (" +
                                std::strerror(error) +
                                "); raise the limit of processes (ulimit -u)"};
}

void ServiceThread::join() noexcept {
  if (!running_) return;
  pthread_join(thread_, nullptr);
  running_ = false;
  unmap_stack(stack_);
}

}  // namespace planecast
