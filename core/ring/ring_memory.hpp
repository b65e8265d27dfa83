// What the rings are made of: the atomics, and the memory order of every access by its place. The
// rings' source is one; tests/core/ring/model runs that same source over modelled memory and
// weakens the orders one at a time.
#pragma once

#include <atomic>
#include <cstdint>
#include <thread>

#include "core/ring/asymmetric_fence.hpp"
#include "core/ring/kernel_wait.hpp"

namespace planecast {

/// The machine's own memory.
struct MachineMemory {
  template <class T>
  using Atomic = std::atomic<T>;
  template <class T>
  using Plain = T;  ///< no atomic: protected by the ring's order alone

  // SpscRing. Where a pair of stores and loads must not pass each other all four are seq_cst.
  static constexpr auto kTailOwn = std::memory_order_relaxed;      ///< producer reads its own
  static constexpr auto kTailPublish = std::memory_order_release;  ///< cell written -> visible
  static constexpr auto kTailPublishFenced =
      std::memory_order_seq_cst;                                    ///< and before kSleeperSeen
  static constexpr auto kTailSeen = std::memory_order_acquire;      ///< visible -> cell read
  static constexpr auto kTailLastLook = std::memory_order_seq_cst;  ///< after kSleepAnnounced
  static constexpr auto kHeadOwn = std::memory_order_relaxed;
  static constexpr auto kHeadPublish = std::memory_order_release;  ///< cell read -> may be reused
  static constexpr auto kHeadSeen = std::memory_order_acquire;     ///< reuse -> cell written
  static constexpr auto kSleepAnnounced = std::memory_order_seq_cst;
  static constexpr auto kSleepEnded = std::memory_order_relaxed;
  static constexpr auto kSleeperSeen = std::memory_order_seq_cst;
  static constexpr auto kSleeperTaken = std::memory_order_relaxed;
  static constexpr auto kClose = std::memory_order_seq_cst;
  static constexpr auto kClosedSeen = std::memory_order_seq_cst;
  // SlotPool.
  static constexpr auto kClaimMark = std::memory_order_relaxed;  ///< the rings order it
  static constexpr auto kCountOwn = std::memory_order_relaxed;
  static constexpr auto kCountPublish = std::memory_order_release;  ///< a drop -> its offer
  static constexpr auto kCountSeen = std::memory_order_acquire;
  // SharedPieces.
  static constexpr auto kPiecesOwn = std::memory_order_relaxed;
  static constexpr auto kPiecesPublish = std::memory_order_release;  ///< job written -> taken
  static constexpr auto kPieceTaken = std::memory_order_acquire;     ///< taken -> job read
  static constexpr auto kPieceFinished = std::memory_order_release;  ///< results, job read -> end
  static constexpr auto kAllFinishedSeen = std::memory_order_acquire;

  static bool asymmetric() noexcept { return asymmetric_fence_available(); }
  static void light_fence() noexcept { planecast::light_fence(); }
  static bool heavy_fence() noexcept { return planecast::heavy_fence(); }

  static void wait(const Atomic<std::uint32_t>& word, std::uint32_t value) noexcept {
    kernel_wait(word, value);
  }
  static void wake_one(Atomic<std::uint32_t>& word) noexcept { kernel_wake_one(word); }
  static void yield() noexcept { std::this_thread::yield(); }
};

}  // namespace planecast
