// The stack of one of our threads: mapped by us, every page present, a guard page below it. So the
// memory of a process is known to the byte before it starts, and a first frame meets no page fault.
#pragma once

#include <pthread.h>

#include <cstddef>
#include <span>

namespace planecast {

/// What a thread may use. The deepest stage takes less than a quarter of it; sanitizers put their
/// own margins round every local variable.
#ifdef PLANECAST_SANITIZED
inline constexpr std::size_t kStackBytes = std::size_t{2} << 20U;
#else
inline constexpr std::size_t kStackBytes = std::size_t{512} << 10U;
#endif

/// A mapping of stack_mapping_bytes(), or none. Trivial, so that it may lie in an arena: whoever
/// maps it unmaps it, after the thread was joined.
struct ThreadStack {
  std::byte* mapping = nullptr;

  /// The part above the guard page; empty without a mapping.
  std::span<std::byte> usable() const noexcept;
};

/// Bytes that map_stack() maps, exactly: kStackBytes in whole pages and the guard page.
std::size_t stack_mapping_bytes() noexcept;

/// Maps a stack, all of it present. No mapping when the system refuses; errno says why.
ThreadStack map_stack() noexcept;

/// Gives the mapping back; nothing happens without one.
void unmap_stack(ThreadStack& stack) noexcept;

/// Runs entry(argument) on `stack`, with all asynchronous signals blocked, so that SIGTERM and
/// friends reach the threads that expect them. Returns 0, or the errno of pthread_create, the stack
/// then being as it was. The caller joins the thread before it unmaps the stack.
int start_on_stack(const ThreadStack& stack, void* (*entry)(void*), void* argument,
                   pthread_t& thread) noexcept;

}  // namespace planecast
