#include "core/base/thread_stack.hpp"

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

}  // namespace planecast
