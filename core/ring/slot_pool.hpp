// Who may use which frame slot: N handles, claimed by the source and given back by the last stage.
// claim() is the one place where a frame can be lost inside a process, so it keeps the counts.
#pragma once

#include <bit>
#include <cstdint>
#include <optional>
#include <span>

#include "core/base/arena.hpp"
#include "core/base/status.hpp"
#include "core/ring/spsc_ring.hpp"

namespace planecast {

/// Handles 0..slots-1. The source's thread calls claim(), claim_wait() and unclaim(); the last
/// thread of the chain calls release(). Nothing here allocates; claim() and release() never block.
template <class Memory>
class BasicSlotPool {
  template <class T>
  using Atomic = typename Memory::template Atomic<T>;
  template <class T>
  using Plain = typename Memory::template Plain<T>;
  using Ring = BasicSpscRing<Memory>;

 public:
  using Cell = Plain<std::uint32_t>;
  using Flag = Atomic<std::uint32_t>;
  static constexpr std::uint32_t kMaxSlots = 4096;

  BasicSlotPool() noexcept = default;
  BasicSlotPool(const BasicSlotPool&) = delete;
  BasicSlotPool& operator=(const BasicSlotPool&) = delete;

  /// Takes the bookkeeping for `slots` (1..kMaxSlots) from the arena; all handles start free.
  /// Returns kBadConfig or kOutOfArena.
  Status init(Arena& arena, std::uint32_t slots) noexcept {
    if (slots == 0 || slots > kMaxSlots) return Status::kBadConfig;
    const std::span<Cell> free = arena.take<Cell>(slots);
    const std::span<Flag> claimed = arena.take<Flag>(slots);
    const std::span<Cell> returned = arena.take<Cell>(std::bit_ceil(slots));
    adopt(free, claimed, returned);
    return arena.failed() ? Status::kOutOfArena : Status::kOk;
  }

  /// The same over memory of the caller's: `free` and `claimed` (zero) one a slot, `returned` a
  /// power of two of at least as many. All empty while an arena measures.
  void adopt(std::span<Cell> free, std::span<Flag> claimed, std::span<Cell> returned) noexcept {
    free_ = free;
    claimed_ = claimed;
    returned_.adopt(returned);
    const auto count = static_cast<std::uint32_t>(free_.size());
    // The last handle lies on top, so slot 0 is claimed first.
    for (std::uint32_t i = 0; i < count; ++i) free_[i] = count - 1 - i;
    free_count_ = count;
  }

  /// Source: a free handle for a new frame, or none when all are in use: that frame is dropped, and
  /// counted. A slot's former contents are visible to the caller.
  std::optional<std::uint32_t> claim() noexcept {
    add(offered_);
    std::uint32_t handle = 0;
    if (take_free(handle) || returned_.try_pop(handle)) return mark(handle);
    add(dropped_);
    return std::nullopt;
  }

  /// Source that must lose nothing (files encoded as fast as possible): waits for a handle; none,
  /// counted as dropped, only after close().
  std::optional<std::uint32_t> claim_wait() noexcept {
    add(offered_);
    std::uint32_t handle = 0;
    if (take_free(handle) || returned_.pop_wait(handle)) return mark(handle);
    add(dropped_);
    return std::nullopt;
  }

  /// Source: gives a claimed handle back unused; its frame counts as dropped.
  void unclaim(std::uint32_t handle) noexcept {
    if (!unmark(handle)) return;
    free_[free_count_] = handle;
    free_count_ = free_count_ + 1;
    add(dropped_);
  }

  /// Last thread: gives a handle back for the source to claim; false, with nothing changed, for a
  /// handle that is not claimed (released twice).
  bool release(std::uint32_t handle) noexcept {
    // The ring has room for every handle and each is inside at most once, so the push succeeds.
    return unmark(handle) && returned_.try_push(handle);
  }

  /// Anyone: ends claim_wait() until reopen().
  void close() noexcept { returned_.close(); }
  void reopen() noexcept { returned_.reopen(); }

  std::uint32_t slots() const noexcept { return static_cast<std::uint32_t>(free_.size()); }

  /// Frames the source has asked a slot for, and those that went without or were given back unused.
  std::uint64_t offered() const noexcept { return offered_.load(Memory::kCountSeen); }
  std::uint64_t dropped() const noexcept { return dropped_.load(Memory::kCountSeen); }

 private:
  bool take_free(std::uint32_t& handle) noexcept {
    if (free_count_ == 0) return false;
    free_count_ = free_count_ - 1;
    handle = free_[free_count_];
    return true;
  }

  std::uint32_t mark(std::uint32_t handle) noexcept {
    claimed_[handle].store(1, Memory::kClaimMark);
    return handle;
  }

  // The rings order this flag's changes; it only has to make a second release harmless.
  bool unmark(std::uint32_t handle) noexcept {
    return handle < claimed_.size() && claimed_[handle].exchange(0, Memory::kClaimMark) != 0;
  }

  // One writer (the source's thread), any reader: no read-modify-write needed. Release, so that who
  // sees a drop also sees it offered.
  static void add(Atomic<std::uint64_t>& counter) noexcept {
    counter.store(counter.load(Memory::kCountOwn) + 1, Memory::kCountPublish);
  }

  std::span<Cell> free_;  ///< stack of handles that the source holds itself
  Plain<std::uint32_t> free_count_{0};
  std::span<Flag> claimed_;
  Atomic<std::uint64_t> offered_{0};
  Atomic<std::uint64_t> dropped_{0};
  Ring returned_;
};

using SlotPool = BasicSlotPool<MachineMemory>;

}  // namespace planecast
