// The pieces of one job at a time, taken by whoever is free: the thread that has the job, or one
// helper. Lock-free; who finds nothing to do sleeps. No allocation.
#pragma once

#include <cstdint>

#include "core/base/arena.hpp"
#include "core/base/work_team.hpp"
#include "core/ring/ring_memory.hpp"

namespace planecast {

/// Roles: one thread calls run(), another help(); start over with reset() before either.
///
/// Why it is correct:
/// * untaken_ counts the pieces of the job that nobody has taken. A piece is taken by lowering it,
///   and only then is the job read: it stays as it is until run() has seen every piece of it
///   finished, this one among them. So piece_ and job_ need no atomics, and a helper that slept
///   through any number of jobs between its look and its exchange takes a piece of the job that is
///   there now.
/// * run() writes the job, then publishes untaken_ (release); taking a piece acquires it. Others
///   that took one in between are read-modify-writes: they carry the release on.
/// * Each piece ends with a release of unfinished_; run() acquires it before it returns, so it sees
///   what the pieces wrote, and nobody reads a job any longer when the next one is written.
/// tests/core/ring/model shows that no weaker order will do.
template <class Memory>
class BasicSharedPieces {
  template <class T>
  using Atomic = typename Memory::template Atomic<T>;
  template <class T>
  using Plain = typename Memory::template Plain<T>;

 public:
  BasicSharedPieces() noexcept = default;
  BasicSharedPieces(const BasicSharedPieces&) = delete;
  BasicSharedPieces& operator=(const BasicSharedPieces&) = delete;

  /// Undoes end(); no other call may be under way.
  void reset() noexcept { untaken_.store(0, Memory::kPiecesPublish); }

  /// Does the pieces, at least one, with the helper's help, and returns when all are done. Waits
  /// for pieces that the helper has taken, never for the helper to wake.
  void run(std::uint32_t pieces, WorkTeam::Piece piece, void* job) noexcept {
    piece_ = piece;
    job_ = job;
    unfinished_.store(pieces, Memory::kPiecesOwn);
    untaken_.store(pieces, Memory::kPiecesPublish);
    Memory::wake_one(untaken_);
    (void)take_all(0);
    for (std::uint32_t left = 0; (left = unfinished_.load(Memory::kAllFinishedSeen)) != 0;)
      Memory::wait(unfinished_, left);
  }

  /// The helper: takes pieces as jobs come, until end().
  void help() noexcept {
    while (take_all(1) != kEnded) Memory::wait(untaken_, 0);
  }

  /// Ends help(), now or when it is next called; run() may not be under way.
  void end() noexcept {
    untaken_.store(kEnded, Memory::kPiecesPublish);
    Memory::wake_one(untaken_);
  }

 private:
  static constexpr std::uint32_t kEnded = ~0U;

  // Returns what is left: 0 or kEnded.
  std::uint32_t take_all(std::uint32_t worker) noexcept {
    std::uint32_t left = untaken_.load(Memory::kPiecesOwn);
    while (left != 0 && left != kEnded) {
      if (!untaken_.compare_exchange_weak(left, left - 1, Memory::kPieceTaken, Memory::kPiecesOwn))
        continue;
      const WorkTeam::Piece piece = piece_;
      piece(job_, left - 1, worker);
      if (unfinished_.fetch_sub(1, Memory::kPieceFinished) == 1) Memory::wake_one(unfinished_);
      left = untaken_.load(Memory::kPiecesOwn);
    }
    return left;
  }

  Plain<WorkTeam::Piece> piece_{nullptr};
  Plain<void*> job_{nullptr};
  alignas(kCacheLineBytes) Atomic<std::uint32_t> untaken_{0};
  alignas(kCacheLineBytes) Atomic<std::uint32_t> unfinished_{0};
};

using SharedPieces = BasicSharedPieces<MachineMemory>;

}  // namespace planecast
