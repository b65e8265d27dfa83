// Who may use which frame slot: N handles, claimed by the source and given back by the last stage.
// claim() is the one place where a frame can be lost inside a process, so it keeps the counts.
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <span>

#include "core/base/arena.hpp"
#include "core/base/status.hpp"
#include "core/ring/spsc_ring.hpp"

namespace planecast {

/// Handles 0..slots-1. The source's thread calls claim(), claim_wait() and unclaim(); the last
/// thread of the chain calls release(). Nothing here allocates; claim() and release() never block.
class SlotPool {
 public:
  static constexpr std::uint32_t kMaxSlots = 4096;

  SlotPool() noexcept = default;
  SlotPool(const SlotPool&) = delete;
  SlotPool& operator=(const SlotPool&) = delete;

  /// Takes the bookkeeping for `slots` (1..kMaxSlots) from the arena; all handles start free.
  /// Returns kBadConfig or kOutOfArena.
  Status init(Arena& arena, std::uint32_t slots) noexcept {
    if (slots == 0 || slots > kMaxSlots) return Status::kBadConfig;
    free_ = arena.take<std::uint32_t>(slots);
    claimed_ = arena.take<std::atomic<std::uint8_t>>(slots);
    if (const Status status = returned_.init(arena, slots); status != Status::kOk) return status;
    free_count_ = static_cast<std::uint32_t>(free_.size());
    // The last handle lies on top, so slot 0 is claimed first.
    for (std::uint32_t i = 0; i < free_count_; ++i) free_[i] = free_count_ - 1 - i;
    return Status::kOk;
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
    free_[free_count_++] = handle;
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
  std::uint64_t offered() const noexcept { return offered_.load(std::memory_order_acquire); }
  std::uint64_t dropped() const noexcept { return dropped_.load(std::memory_order_acquire); }

 private:
  bool take_free(std::uint32_t& handle) noexcept {
    if (free_count_ == 0) return false;
    handle = free_[--free_count_];
    return true;
  }

  std::uint32_t mark(std::uint32_t handle) noexcept {
    claimed_[handle].store(1, std::memory_order_relaxed);
    return handle;
  }

  // The rings order this flag's changes; it only has to make a second release harmless.
  bool unmark(std::uint32_t handle) noexcept {
    return handle < claimed_.size() && claimed_[handle].exchange(0, std::memory_order_relaxed) != 0;
  }

  // One writer (the source's thread), any reader: no read-modify-write needed. Release, so that who
  // sees a drop also sees it offered.
  static void add(std::atomic<std::uint64_t>& counter) noexcept {
    counter.store(counter.load(std::memory_order_relaxed) + 1, std::memory_order_release);
  }

  std::span<std::uint32_t> free_;  ///< stack of handles that the source holds itself
  std::uint32_t free_count_ = 0;
  std::span<std::atomic<std::uint8_t>> claimed_;
  std::atomic<std::uint64_t> offered_{0};
  std::atomic<std::uint64_t> dropped_{0};
  SpscRing returned_;
};

}  // namespace planecast
