#include "transport/service_thread.hpp"

#include <signal.h>

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
  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  pthread_attr_setstack(&attributes, stack_.usable().data(), stack_.usable().size());
  sigset_t blocked;
  sigset_t before;
  sigfillset(&blocked);
  // A fault is delivered to the thread that made it; blocked, it would bypass a crash handler.
  for (const int fault : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGTRAP, SIGSYS})
    sigdelset(&blocked, fault);
  pthread_sigmask(SIG_SETMASK, &blocked, &before);
  const int error = pthread_create(&thread_, &attributes, &ServiceThread::run, this);
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  pthread_attr_destroy(&attributes);
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
