// Between the replaced libc calls (heap_guard_hooks.cpp) and the bookkeeping (heap_guard.cpp).
#pragma once

#include <cstddef>
#include <cstdint>

namespace planecast::test {

#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer) || \
    __has_feature(memory_sanitizer)
#define PLANECAST_GUARD_OFF 1
#endif
#endif
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define PLANECAST_GUARD_OFF 1
#endif

#ifdef PLANECAST_GUARD_OFF
inline constexpr bool kHooksCompiledIn = false;
#else
inline constexpr bool kHooksCompiledIn = true;
#endif

enum class Offence : std::uint8_t {
  kAllocate = 0,
  kFree = 1,
  kMap = 2,
  kMutex = 3,
  kWrite = 4,
  kWait = 5,
  kIdle = 6,  ///< no offence
};
inline constexpr std::size_t kOffenceKinds = 7;

/// True when calls of this thread count at the moment.
bool guard_armed() noexcept;

/// Counts bytes mapped when `caller` lies in the main program.
void guard_mapped(std::size_t bytes, const void* caller) noexcept;

/// Counts a call of the calling thread when it is armed, and keeps the first one's backtrace.
void guard_report(Offence kind, const char* call) noexcept;

}  // namespace planecast::test
