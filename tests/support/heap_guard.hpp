// Catches heap use, page faults and blocking calls on threads that must do none. The object library
// planecast_heap_guard replaces malloc and friends and the blocking calls of a test program, the
// shared one of guard_preload.cpp those of any program; they count only on armed threads. Waits on
// an empty queue (std::atomic::wait, sem_clockwait) are allowed. Calls that libc makes to itself
// (printf -> write) are not seen, those it makes to malloc are.
#pragma once

#include <cstdint>
#include <string>

namespace planecast::test {

struct HeapGuardTotals {
  std::uint64_t allocations = 0;  ///< malloc, calloc, realloc, memalign and friends, operator new
  std::uint64_t frees = 0;        ///< free of a block, operator delete
  std::uint64_t maps = 0;         ///< mmap, munmap, mremap, brk, sbrk, madvise
  std::uint64_t mutex_waits = 0;  ///< mutex that another thread holds, condition
  std::uint64_t writes = 0;       ///< write, writev, send, sendmsg, fsync
  std::uint64_t waits = 0;        ///< sleep, poll, select, read, recv, join
  std::uint64_t idle = 0;         ///< sem_clockwait: for the next frame, allowed
  std::uint64_t minor_faults = 0, major_faults = 0;  ///< pages; of a thread that ended or disarmed
  std::uint64_t blocks() const noexcept { return mutex_waits + writes + waits; }
  std::uint64_t faults() const noexcept { return minor_faults + major_faults; }
  std::uint64_t sum() const noexcept { return allocations + frees + maps + blocks(); }
};

/// Static functions only: arm_this_thread fits StageRunner's on_thread_start hook.
struct HeapGuard {
  /// False under a sanitizer, which brings its own malloc: nothing is replaced and all counts stay
  /// 0.
  static bool available() noexcept;

  /// Counts from here on for the calling thread; `name` (a constant) appears in the report.
  static void arm_this_thread(const char* name) noexcept;
  static void disarm_this_thread(const char* name = "") noexcept;

  /// Sums over all armed threads since reset().
  static HeapGuardTotals totals() noexcept;

  /// Counts of the calling thread since it was armed.
  static HeapGuardTotals this_thread() noexcept;

  /// Clears totals and the first offender; while no armed thread misbehaves.
  static void reset() noexcept;

  /// Called once for each armed thread that ended or was disarmed, on that thread, with its counts.
  static void on_finish(void (*call)(const char* name, const HeapGuardTotals& counts)) noexcept;

  /// Bytes that the main program itself has mapped since it began, what it unmapped included.
  static std::uint64_t mapped_by_program() noexcept;

  /// Thread, call and backtrace of the first offence; empty when there was none.
  static std::string first_offender();
};

}  // namespace planecast::test

#define PLANECAST_NEED_HEAP_GUARD()               \
  if (!::planecast::test::HeapGuard::available()) \
  GTEST_SKIP() << "a sanitizer owns malloc in this build"
