#include "core/ring/kernel_wait.hpp"

#if defined(__linux__)
#include <linux/futex.h>
#include <sys/syscall.h>
#include <unistd.h>
#endif

namespace planecast {

#if defined(__linux__) && defined(SYS_futex)

// Not std::atomic::wait: libstdc++ 12 yields the core a few times before it sleeps, and decides
// whether to wake by a count of its own that is not ordered against the word.
static_assert(sizeof(std::atomic<std::uint32_t>) == sizeof(std::uint32_t) &&
              std::atomic<std::uint32_t>::is_always_lock_free);

void kernel_wait(const std::atomic<std::uint32_t>& word, std::uint32_t value) noexcept {
  ::syscall(SYS_futex, &word, FUTEX_WAIT_PRIVATE, value, nullptr, nullptr, 0);
}

void kernel_wake_one(std::atomic<std::uint32_t>& word) noexcept {
  ::syscall(SYS_futex, &word, FUTEX_WAKE_PRIVATE, 1, nullptr, nullptr, 0);
}

#else

void kernel_wait(const std::atomic<std::uint32_t>& word, std::uint32_t value) noexcept {
  word.wait(value, std::memory_order_seq_cst);
}

void kernel_wake_one(std::atomic<std::uint32_t>& word) noexcept {
  word.notify_one();
}

#endif

}  // namespace planecast
