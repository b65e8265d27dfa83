// A ring of 32-bit handles between exactly one producer and one consumer thread: lock-free, fixed
// memory, and a consumer that sleeps when it is empty. Frames stay where they are; handles move.
#pragma once

#include <atomic>
#include <bit>
#include <chrono>
#include <cstdint>
#include <span>

#include "core/base/arena.hpp"
#include "core/base/status.hpp"

namespace planecast {

/// Single-producer single-consumer queue of handles (after rigtorp's SPSCQueue: cached opposite
/// index, one cache line for each side's words).
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
///   producer writes tail_ (close() writes closed_), then looks at sleeping_. All four are seq_cst,
///   so at least one side sees the other's write: the consumer finds the handle and does not
///   sleep, or the producer finds the sleeper and wakes it. With a release store in place of the
///   seq_cst one both may miss (store buffering), also through std::atomic::notify_one, whose own
///   look for waiters comes after the store. No fences, because ThreadSanitizer does not know them.
/// * The waker turns sleeping_ to 0 before it notifies, and the futex sleeps only while the word
///   still is 1; so a wake between the look and the sleep is not lost. A late waker may hit a
///   consumer's next sleep: it wakes, finds nothing, and sleeps again.
class SpscRing {
 public:
  static constexpr std::uint32_t kMaxCapacity = 1U << 31U;

  SpscRing() noexcept = default;
  SpscRing(const SpscRing&) = delete;
  SpscRing& operator=(const SpscRing&) = delete;

  /// Takes the cells, min_capacity in 1..2^31 rounded up to a power of two, from the arena.
  /// `first_index` is where both counters start (tests of the wrap). Before any thread uses it.
  /// Returns kBadConfig or kOutOfArena.
  Status init(Arena& arena, std::uint32_t min_capacity, std::uint32_t first_index = 0) noexcept {
    if (min_capacity == 0 || min_capacity > kMaxCapacity) return Status::kBadConfig;
    cells_ = arena.take<std::uint32_t>(std::bit_ceil(min_capacity));
    if (arena.failed()) return Status::kOutOfArena;
    head_.store(first_index, std::memory_order_relaxed);
    tail_.store(first_index, std::memory_order_relaxed);
    cached_head_ = cached_tail_ = first_index;
    return Status::kOk;
  }

  /// Sets for how long pop_wait() polls before it sleeps [ns], 0 = not at all. Consumer, or before
  /// it starts. Polling pays only where every thread has a core of its own.
  void set_spin_ns(std::uint32_t spin_ns) noexcept { spin_ns_ = spin_ns; }

  /// Producer: appends a handle and wakes a sleeping consumer; false when full. Wait-free but for
  /// the wake, one system call that happens only when the consumer sleeps.
  [[nodiscard]] bool try_push(std::uint32_t handle) noexcept {
    const std::uint32_t tail = tail_.load(std::memory_order_relaxed);
    if (tail - cached_head_ >= capacity()) {
      cached_head_ = head_.load(std::memory_order_acquire);
      if (tail - cached_head_ >= capacity()) return false;
    }
    cells_[tail & (capacity() - 1)] = handle;
    tail_.store(tail + 1, std::memory_order_seq_cst);
    wake_sleeper();
    return true;
  }

  /// Consumer: takes the oldest handle; false when empty. Wait-free.
  [[nodiscard]] bool try_pop(std::uint32_t& handle) noexcept {
    const std::uint32_t head = head_.load(std::memory_order_relaxed);
    if (head == cached_tail_) {
      cached_tail_ = tail_.load(std::memory_order_acquire);
      if (head == cached_tail_) return false;
    }
    handle = cells_[head & (capacity() - 1)];
    head_.store(head + 1, std::memory_order_release);
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
    closed_.store(1, std::memory_order_seq_cst);
    wake_sleeper();
  }

  /// Undoes close(); handles inside stay. Anyone; a consumer that still sleeps keeps waiting.
  void reopen() noexcept { closed_.store(0, std::memory_order_seq_cst); }

  bool closed() const noexcept { return closed_.load(std::memory_order_seq_cst) != 0; }

  /// Number of handles inside; exact for neither side while the other one works.
  std::uint32_t size() const noexcept {
    const std::uint32_t head = head_.load(std::memory_order_acquire);
    return tail_.load(std::memory_order_acquire) - head;
  }

  std::uint32_t capacity() const noexcept { return static_cast<std::uint32_t>(cells_.size()); }

 private:
  void wake_sleeper() noexcept {
    if (sleeping_.load(std::memory_order_seq_cst) == 0) return;
    if (sleeping_.exchange(0, std::memory_order_seq_cst) != 0) sleeping_.notify_one();
  }

  void sleep_while_empty() noexcept {
    sleeping_.store(1, std::memory_order_seq_cst);
    const bool empty =
        tail_.load(std::memory_order_seq_cst) == head_.load(std::memory_order_relaxed);
    if (empty && !closed()) sleeping_.wait(1, std::memory_order_seq_cst);
    sleeping_.store(0, std::memory_order_relaxed);
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
  std::span<std::uint32_t> cells_;
  std::uint32_t spin_ns_ = 0;

  // The producer's line.
  alignas(kCacheLineBytes) std::atomic<std::uint32_t> tail_{0};
  std::uint32_t cached_head_ = 0;

  // The consumer's line.
  alignas(kCacheLineBytes) std::atomic<std::uint32_t> head_{0};
  std::uint32_t cached_tail_ = 0;

  // Written only when the ring runs empty or closes; 32-bit because libstdc++ waits on a word of
  // that size directly in the kernel.
  alignas(kCacheLineBytes) std::atomic<std::uint32_t> sleeping_{0};
  std::atomic<std::uint32_t> closed_{0};
};

}  // namespace planecast
