#include "core/base/thread_stack.hpp"

#include <signal.h>
#include <sys/mman.h>
#include <unistd.h>

namespace planecast {
namespace {

std::size_t page_bytes() noexcept {
  const long bytes = ::sysconf(_SC_PAGESIZE);
  return bytes > 0 ? static_cast<std::size_t>(bytes) : 4096;
}

}  // namespace

std::span<std::byte> ThreadStack::usable() const noexcept {
  if (mapping == nullptr) return {};
  return {mapping + page_bytes(), stack_mapping_bytes() - page_bytes()};
}

std::size_t stack_mapping_bytes() noexcept {
  const std::size_t page = page_bytes();
  return (kStackBytes + page - 1) / page * page + page;
}

ThreadStack map_stack() noexcept {
  const std::size_t bytes = stack_mapping_bytes();
  void* mapping = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE,
                         MAP_PRIVATE | MAP_ANONYMOUS | MAP_STACK | MAP_POPULATE, -1, 0);
  if (mapping == MAP_FAILED) return {};
  if (::mprotect(mapping, page_bytes(), PROT_NONE) != 0) {
    ::munmap(mapping, bytes);
    return {};
  }
  return {static_cast<std::byte*>(mapping)};
}

void unmap_stack(ThreadStack& stack) noexcept {
  if (stack.mapping != nullptr) ::munmap(stack.mapping, stack_mapping_bytes());
  stack = {};
}

int start_on_stack(const ThreadStack& stack, void* (*entry)(void*), void* argument,
                   pthread_t& thread) noexcept {
  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  pthread_attr_setstack(&attributes, stack.usable().data(), stack.usable().size());
  sigset_t blocked;
  sigset_t before;
  sigfillset(&blocked);
  // A fault is delivered to the thread that made it; blocked, it would bypass a crash handler.
  for (const int fault : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGTRAP, SIGSYS})
    sigdelset(&blocked, fault);
  pthread_sigmask(SIG_SETMASK, &blocked, &before);
  const int error = pthread_create(&thread, &attributes, entry, argument);
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  pthread_attr_destroy(&attributes);
  return error;
}

}  // namespace planecast
