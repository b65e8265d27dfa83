#include "tests/transport/network/malloc_count.hpp"

#include <atomic>
#include <cerrno>
#include <cstddef>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define PLANECAST_COUNT_MALLOC 0
#else
#define PLANECAST_COUNT_MALLOC 1
#endif

namespace planecast::test {

std::atomic<std::uint64_t> counted{0};

bool malloc_is_counted() noexcept {
  return PLANECAST_COUNT_MALLOC == 1;
}

std::uint64_t malloc_count() noexcept {
  return counted.load(std::memory_order_relaxed);
}

}  // namespace planecast::test

#if PLANECAST_COUNT_MALLOC
// glibc's own names of the functions replaced below.
extern "C" {
void* __libc_malloc(std::size_t size);                       // NOLINT
void* __libc_calloc(std::size_t count, std::size_t size);    // NOLINT
void* __libc_realloc(void* block, std::size_t size);         // NOLINT
void* __libc_memalign(std::size_t align, std::size_t size);  // NOLINT

void* malloc(std::size_t size) {
  planecast::test::counted.fetch_add(1, std::memory_order_relaxed);
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) {
  planecast::test::counted.fetch_add(1, std::memory_order_relaxed);
  return __libc_calloc(count, size);
}
void* realloc(void* block, std::size_t size) {
  planecast::test::counted.fetch_add(1, std::memory_order_relaxed);
  return __libc_realloc(block, size);
}
void* memalign(std::size_t align, std::size_t size) {
  planecast::test::counted.fetch_add(1, std::memory_order_relaxed);
  return __libc_memalign(align, size);
}
void* aligned_alloc(std::size_t align, std::size_t size) {
  return memalign(align, size);
}
int posix_memalign(void** block, std::size_t align, std::size_t size) {
  *block = memalign(align, size);
  return *block == nullptr ? ENOMEM : 0;
}
}
#endif
