// Store-load ordering at the expense of one side: the side that goes to sleep pays for both, so
// that every push costs a plain store and no fence.
#pragma once

#include <atomic>

namespace planecast {

/// True where the kernel can run a memory barrier in all threads of this process (Linux 4.14 and
/// later); registers the process at the first call. Any thread.
bool asymmetric_fence_available() noexcept;

/// Makes every running thread of the process pass a full memory barrier before it returns; false,
/// with no effect, where the kernel refuses. One system call, 0.1 to 0.4 us.
bool heavy_fence() noexcept;

/// The other side's half: keeps the compiler from reordering, costs nothing.
inline void light_fence() noexcept {
  std::atomic_signal_fence(std::memory_order_seq_cst);
}

}  // namespace planecast
