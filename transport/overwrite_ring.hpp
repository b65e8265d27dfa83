// Slots handed from one producing to one consuming thread, oldest first, where the producer may
// take back the oldest that the consumer has not yet begun: it never waits, and what is lost is
// whole and counted. One atomic word a slot holds state and sequence, so a slot refilled in between
// is noticed.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>

namespace planecast {

class OverwriteRing {
 public:
  using Word = std::atomic<std::uint64_t>;
  static constexpr int kNone = -1;

  OverwriteRing() noexcept = default;
  OverwriteRing(const OverwriteRing&) = delete;
  OverwriteRing& operator=(const OverwriteRing&) = delete;

  /// Before use. `words`: one a slot, zero at first, owned by the caller and outliving the ring.
  void init(std::span<Word> words) noexcept {
    words_ = words.data();
    slots_ = static_cast<int>(words.size());
  }

  int slots() const noexcept { return slots_; }

  /// Producer: a free slot to write, or kNone. O(slots).
  int claim() noexcept {
    for (int slot = 0; slot < slots_; ++slot) {
      // Acquire pairs with release(): the consumer has finished reading.
      if (state(words_[slot].load(std::memory_order_acquire)) != kFree) continue;
      words_[slot].store(kClaimed, std::memory_order_relaxed);
      return slot;
    }
    return kNone;
  }

  /// Producer: takes back the oldest queued slot to write it anew; kNone when fewer than
  /// `min_queued` (at least 1) are queued.
  int claim_oldest(int min_queued = 1) noexcept { return move_oldest(kClaimed, min_queued); }

  /// Producer: hands a claimed slot over as the newest.
  void publish(int slot) noexcept {
    const std::uint64_t sequence = published_.load(std::memory_order_relaxed) + 1;
    words_[slot].store((sequence << kStateBits) | kQueued, std::memory_order_release);
    published_.store(sequence, std::memory_order_release);
  }

  /// Producer: gives a claimed slot back unused.
  void abandon(int slot) noexcept { words_[slot].store(kFree, std::memory_order_relaxed); }

  /// Consumer: the oldest queued slot to read, or kNone.
  int take() noexcept { return move_oldest(kTaken, 1); }

  /// Consumer: gives a taken slot back.
  void release(int slot) noexcept { words_[slot].store(kFree, std::memory_order_release); }

  /// Either thread: slots queued at about this moment.
  int queued() const noexcept {
    int count = 0;
    for (int slot = 0; slot < slots_; ++slot)
      count += state(words_[slot].load(std::memory_order_relaxed)) == kQueued ? 1 : 0;
    return count;
  }

 private:
  static constexpr unsigned kStateBits = 2;
  enum State : std::uint64_t { kFree = 0, kClaimed = 1, kQueued = 2, kTaken = 3 };
  static State state(std::uint64_t word) noexcept { return static_cast<State>(word & 3U); }

  // Only what was published before the look over the slots began takes part: two slots published
  // during it could be seen the newer one alone. Of those the smallest sequence found is still the
  // oldest if its word has not changed; a failed exchange means that the other thread moved that
  // very slot on, so it is counted anew. Each retry means that the other thread made progress.
  int move_oldest(State to, int min_queued) noexcept {
    for (;;) {
      const std::uint64_t published = published_.load(std::memory_order_acquire);
      int oldest = kNone;
      int count = 0;
      std::uint64_t oldest_word = 0;
      for (int slot = 0; slot < slots_; ++slot) {
        const std::uint64_t word = words_[slot].load(std::memory_order_acquire);
        if (state(word) != kQueued || (word >> kStateBits) > published) continue;
        ++count;
        if (oldest != kNone && word >= oldest_word) continue;
        oldest = slot;
        oldest_word = word;
      }
      if (count < min_queued) {
        if (published_.load(std::memory_order_relaxed) == published) return kNone;
        continue;  // what was seen may have been taken back, and newer slots not yet looked at
      }
      if (words_[oldest].compare_exchange_strong(oldest_word, to, std::memory_order_acq_rel,
                                                 std::memory_order_relaxed))
        return oldest;
    }
  }

  Word* words_ = nullptr;
  int slots_ = 0;
  std::atomic<std::uint64_t> published_{0};  ///< sequence of the newest slot; producer's
};

}  // namespace planecast
