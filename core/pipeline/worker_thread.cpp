#include "core/pipeline/worker_thread.hpp"

#include <sched.h>

#include <array>
#include <cerrno>
#include <cstring>

namespace planecast {
namespace {

constexpr std::uint32_t kSpinNs = 20'000;

void set_name(const char* name) noexcept {
  std::array<char, 16> cut{};  // the kernel's limit, NUL included
  std::strncpy(cut.data(), name, cut.size() - 1);
  pthread_setname_np(pthread_self(), cut.data());
}

bool set_fifo(int priority) noexcept {
  sched_param parameters{};
  parameters.sched_priority = priority;
  return pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters) == 0;
}

bool set_core(int index) noexcept {
  cpu_set_t allowed;
  if (sched_getaffinity(0, sizeof(allowed), &allowed) != 0) return false;
  int skip = index % CPU_COUNT(&allowed);
  for (int core = 0; core < CPU_SETSIZE; ++core) {
    if (!CPU_ISSET(core, &allowed) || skip-- > 0) continue;
    cpu_set_t one;
    CPU_ZERO(&one);
    CPU_SET(core, &one);
    return pthread_setaffinity_np(pthread_self(), sizeof(one), &one) == 0;
  }
  return false;
}

}  // namespace

int WorkerThread::start(void* (*entry)(void*), void* argument) noexcept {
  stack = map_stack();
  if (stack.mapping == nullptr) return errno;
  const int error = start_on_stack(stack, entry, argument, thread);
  running = error == 0;
  if (!running) unmap_stack(stack);
  return error;
}

void WorkerThread::join() noexcept {
  if (!running) return;
  pthread_join(thread, nullptr);
  running = false;
  unmap_stack(stack);
}

ThreadRefusals prepare_worker(const ThreadWishes& wishes) noexcept {
  ThreadRefusals refused;
  if (wishes.fifo_priority > 0) refused.fifo = !set_fifo(wishes.fifo_priority);
  if (wishes.core >= 0) refused.affinity = !set_core(wishes.core);
  set_name(wishes.name);
  return refused;
}

std::uint32_t suitable_spin_ns(std::uint32_t threads) noexcept {
  cpu_set_t allowed;
  if (sched_getaffinity(0, sizeof(allowed), &allowed) != 0) return 0;
  return static_cast<std::uint32_t>(CPU_COUNT(&allowed)) > threads ? kSpinNs : 0;
}

}  // namespace planecast
