// A ring of 32-bit handles between exactly one producer and one consumer thread: lock-free, fixed
// memory, and a consumer that sleeps when it is empty. Frames stay where they are; handles move.
#pragma once

#include <bit>
#include <chrono>
#include <cstdint>
#include <span>

#include "core/base/arena.hpp"
#include "core/base/status.hpp"
#include "core/ring/ring_memory.hpp"

namespace planecast {

/// Single-producer single-consumer queue of handles (after rigtorp's SPSCQueue: one cache line for
/// each side's words, and the consumer keeps a copy of the producer's index; the producer keeps
/// none of the consumer's, which measured two to three times faster: it stops chasing its
/// consumer).
///
/// Roles: one thread pushes, one thread pops; a role may be handed to another thread only through a
/// synchronisation such as join. Anyone may close() and read size(). No call allocates or throws.
///
/// Why it is correct:
/// * tail_ counts pushes and head_ counts pops; both run freely over 2^32, their difference is the
///   fill. Each is written by one side only.
/// * Cell contents: the producer's store to tail_ (release or stronger) and the consumer's acquire
///   load of it order the cell's write before its read; head_ does the same the other way round, so
///   a cell is not overwritten before it was read.
/// * Sleep: the consumer writes sleeping_ = 1, then looks at tail_ and closed_ once more; the
///   producer writes tail_ (close() writes closed_), then looks at sleeping_. At least one side
///   must see the other's write: the consumer finds the handle and does not sleep, or the producer
///   finds the sleeper and wakes it. With plain release stores both may miss (store buffering).
///   Where the kernel offers it, the consumer makes all threads pass a barrier between its two
///   steps (heavy_fence), and a push is a plain store; elsewhere all four accesses are seq_cst,
///   which on x86 makes the producer wait for its cache line at every push. close() is always
///   seq_cst. tests/core/ring/model shows for both ways that no weaker order will do.
/// * The waker turns sleeping_ to 0 before it notifies, and the futex sleeps only while the word
///   still is 1; so a wake between the look and the sleep is not lost. A late waker may hit a
///   consumer's next sleep: it wakes, finds nothing, and sleeps again.
template <class Memory>
class BasicSpscRing {
  template <class T>
  using Atomic = typename Memory::template Atomic<T>;
  template <class T>
  using Plain = typename Memory::template Plain<T>;

 public:
  using Cell = Plain<std::uint32_t>;
  static constexpr std::uint32_t kMaxCapacity = 1U << 31U;

  BasicSpscRing() noexcept = default;
  BasicSpscRing(const BasicSpscRing&) = delete;
  BasicSpscRing& operator=(const BasicSpscRing&) = delete;

  /// Takes the cells, min_capacity in 1..2^31 rounded up to a power of two, from the arena.
  /// `first_index` is where both counters start (tests of the wrap). Before any thread uses it.
  /// Returns kBadConfig or kOutOfArena.
  Status init(Arena& arena, std::uint32_t min_capacity, std::uint32_t first_index = 0) noexcept {
    if (min_capacity == 0 || min_capacity > kMaxCapacity) return Status::kBadConfig;
    adopt(arena.take<Cell>(std::bit_ceil(min_capacity)), first_index);
    return arena.failed() ? Status::kOutOfArena : Status::kOk;
  }

  /// The same over cells of the caller's, a power of two of them (none: always full and empty).
  void adopt(std::span<Cell> cells, std::uint32_t first_index = 0) noexcept {
    cells_ = cells;
    asymmetric_ = Memory::asymmetric();
    head_.store(first_index, Memory::kHeadOwn);
    tail_.store(first_index, Memory::kTailOwn);
    cached_tail_ = first_index;
  }

  /// Sets for how long pop_wait() polls before it sleeps [ns], 0 = not at all. Consumer, or before
  /// it starts. Polling pays only where every thread has a core of its own.
  void set_spin_ns(std::uint32_t spin_ns) noexcept { spin_ns_ = spin_ns; }

  /// Producer: appends a handle and wakes a sleeping consumer; false when full. Wait-free but for
  /// the wake, one system call that happens only when the consumer sleeps.
  [[nodiscard]] bool try_push(std::uint32_t handle) noexcept {
    const std::uint32_t tail = tail_.load(Memory::kTailOwn);
    if (tail - head_.load(Memory::kHeadSeen) >= capacity()) return false;
    cells_[tail & (capacity() - 1)] = handle;
    if (asymmetric_) {
      tail_.store(tail + 1, Memory::kTailPublish);
      Memory::light_fence();
    } else {
      tail_.store(tail + 1, Memory::kTailPublishFenced);
    }
    wake_sleeper();
    return true;
  }

  /// Consumer: takes the oldest handle; false when empty. Wait-free.
  [[nodiscard]] bool try_pop(std::uint32_t& handle) noexcept {
    const std::uint32_t head = head_.load(Memory::kHeadOwn);
    if (head == cached_tail_) {
      cached_tail_ = tail_.load(Memory::kTailSeen);
      if (head == cached_tail_) return false;
    }
    handle = cells_[head & (capacity() - 1)];
    head_.store(head + 1, Memory::kHeadPublish);
    return true;
  }

  /// Consumer: takes the oldest handle, polling and then sleeping while there is none; false only
  /// when the ring is closed and empty.
  [[nodiscard]] bool pop_wait(std::uint32_t& handle) noexcept {
    for (;;) {
      if (try_pop(handle)) return true;
      // All that was pushed before close() is still delivered: look again after seeing it closed.
      if (closed()) return try_pop(handle);
      if (spin(handle)) return true;
      sleep_while_empty();
    }
  }

  /// Anyone: lets pop_wait() return false once the ring is empty, and wakes it; stays in force
  /// until reopen(), so it cannot be missed. Pushing afterwards still works but nobody waits for
  /// it.
  void close() noexcept {
    closed_.store(1, Memory::kClose);
    wake_sleeper();
  }

  /// Undoes close(); handles inside stay. Anyone; a consumer that still sleeps keeps waiting.
  void reopen() noexcept { closed_.store(0, Memory::kClose); }

  bool closed() const noexcept { return closed_.load(Memory::kClosedSeen) != 0; }

  /// Number of handles inside; exact for neither side while the other one works.
  std::uint32_t size() const noexcept {
    const std::uint32_t head = head_.load(Memory::kHeadSeen);
    return tail_.load(Memory::kTailSeen) - head;
  }

  std::uint32_t capacity() const noexcept { return static_cast<std::uint32_t>(cells_.size()); }

 private:
  void wake_sleeper() noexcept {
    if (sleeping_.load(Memory::kSleeperSeen) == 0) return;
    if (sleeping_.exchange(0, Memory::kSleeperTaken) != 0) Memory::wake_one(sleeping_);
  }

  void sleep_while_empty() noexcept {
    sleeping_.store(1, Memory::kSleepAnnounced);
    if (asymmetric_ && !Memory::heavy_fence()) {
      // Not seen on any kernel that granted the registration; then the ring is polled.
      Memory::yield();
    } else if (tail_.load(Memory::kTailLastLook) == head_.load(Memory::kHeadOwn) && !closed()) {
      Memory::wait(sleeping_, 1);
    }
    sleeping_.store(0, Memory::kSleepEnded);
  }

  bool spin(std::uint32_t& handle) noexcept {
    if (spin_ns_ == 0) return false;
    const auto end = std::chrono::steady_clock::now() + std::chrono::nanoseconds(spin_ns_);
    do {
      for (int i = 0; i < 16; ++i) cpu_relax();
      if (try_pop(handle)) return true;
    } while (!closed() && std::chrono::steady_clock::now() < end);
    return false;
  }

  static void cpu_relax() noexcept {
#if defined(__x86_64__) || defined(__i386__)
    __builtin_ia32_pause();
#elif defined(__aarch64__)
    asm volatile("yield");
#endif
  }

  // Read-only after init().
  std::span<Cell> cells_;
  std::uint32_t spin_ns_ = 0;
  bool asymmetric_ = false;

  // The producer's line.
  alignas(kCacheLineBytes) Atomic<std::uint32_t> tail_{0};

  // The consumer's line.
  alignas(kCacheLineBytes) Atomic<std::uint32_t> head_{0};
  Plain<std::uint32_t> cached_tail_{0};

  // Written only when the ring runs empty or closes; 32-bit because libstdc++ waits on a word of
  // that size directly in the kernel.
  alignas(kCacheLineBytes) Atomic<std::uint32_t> sleeping_{0};
  Atomic<std::uint32_t> closed_{0};
};

using SpscRing = BasicSpscRing<MachineMemory>;

}  // namespace planecast
