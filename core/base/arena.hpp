// One block of memory from which everything that runs is carved at start, and nothing after.
// The same layout code runs twice: over Arena::measuring() it only counts, over a real arena it
// carves; so memory_bytes(config) and the memory in use agree to the byte.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <type_traits>

#include "core/base/status.hpp"

namespace planecast {

inline constexpr std::size_t kCacheLineBytes = 64;

/// Wishes for a mapped arena; one that the machine refuses is a flag, never an error.
struct ArenaOptions {
  bool lock = false;        ///< keep the pages in RAM (mlock; needs RLIMIT_MEMLOCK)
  bool huge_pages = false;  ///< back the block by 2 MiB pages
};

/// A bump allocator over one block. Not thread-safe: used while starting, by one thread.
///
/// Layout code takes all it needs, then asks failed() once, and touches the memory only when
/// is_measuring() is false (spans are empty while measuring, so loops over them do nothing).
class Arena {
 public:
  static constexpr std::size_t kMaxAlign = kCacheLineBytes;

  /// An arena of no bytes: the first take() that wants any fails.
  Arena() noexcept = default;
  ~Arena();
  Arena(Arena&& other) noexcept;
  Arena& operator=(Arena&& other) noexcept;

  /// An arena without memory that counts what a layout would take; see bytes_needed().
  static Arena measuring() noexcept;

  /// Maps `bytes` of zeroed memory, every page present before it returns (no page fault later).
  /// Fails with kOutOfArena when the system refuses the mapping.
  static Result<Arena> map(std::size_t bytes, ArenaOptions options = {});

  /// Uses the caller's block, which stays the caller's and must outlive the arena.
  /// Fails with kBadConfig unless the block starts on a multiple of kMaxAlign bytes.
  static Result<Arena> over(std::span<std::byte> block);

  /// Takes n value-initialised objects, starting on a multiple of `align` bytes (a power of two,
  /// at most kMaxAlign). Empty while measuring, for n = 0, and on failure, which failed() keeps:
  /// too little memory left, a bad alignment, or a sealed arena. O(n).
  template <class T>
  std::span<T> take(std::size_t n, std::size_t align = kCacheLineBytes) noexcept {
    static_assert(std::is_trivially_destructible_v<T>, "an arena never runs destructors");
    static_assert(std::is_nothrow_default_constructible_v<T>);
    static_assert(alignof(T) <= kMaxAlign);
    if (n == 0) return {};
    std::byte* bytes = carve(n, sizeof(T), align < alignof(T) ? alignof(T) : align);
    if (bytes == nullptr) return {};
    T* first = reinterpret_cast<T*>(bytes);
    std::uninitialized_value_construct_n(first, n);
    return {first, n};
  }

  /// Makes every later take() of at least one object fail: the start is over.
  void seal() noexcept { sealed_ = true; }

  bool sealed() const noexcept { return sealed_; }
  bool is_measuring() const noexcept { return measuring_; }

  /// True once any take() has failed; never cleared.
  bool failed() const noexcept { return failed_; }

  /// Bytes that all takes so far want, padding included and failed ones counted too (those refused
  /// for a bad alignment, an overflow or the seal are not): what the block would have to hold.
  std::size_t bytes_needed() const noexcept { return needed_; }

  /// High-water mark: bytes of the block handed out, padding included.
  std::size_t bytes_used() const noexcept { return used_; }

  std::size_t capacity() const noexcept { return block_.size(); }

  /// True when locking was asked for and the system said no.
  bool lock_refused() const noexcept { return lock_refused_; }

  /// True when huge pages were asked for and the system offers neither reserved nor transparent
  /// ones.
  bool huge_pages_refused() const noexcept { return huge_pages_refused_; }

 private:
  std::byte* carve(std::size_t n, std::size_t size, std::size_t align) noexcept;
  bool map_block(std::size_t bytes, bool huge_pages) noexcept;
  void swap(Arena& other) noexcept;

  std::span<std::byte> block_;
  void* mapping_ = nullptr;  ///< what to unmap; null for a caller's block
  std::size_t mapped_bytes_ = 0;
  std::size_t needed_ = 0;
  std::size_t used_ = 0;
  bool measuring_ = false;
  bool sealed_ = false;
  bool failed_ = false;
  bool lock_refused_ = false;
  bool huge_pages_refused_ = false;
};

}  // namespace planecast
