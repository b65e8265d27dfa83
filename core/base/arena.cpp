#include "core/base/arena.hpp"

#include <sys/mman.h>

#include <bit>
#include <cerrno>
#include <cstring>
#include <limits>
#include <string>
#include <utility>

namespace planecast {
namespace {

constexpr std::size_t kHugePageBytes = std::size_t{2} << 20U;
constexpr std::size_t kSmallestPageBytes = 4096;

void* map_anonymous(std::size_t bytes, int extra_flags) noexcept {
  void* block = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE,
                       MAP_PRIVATE | MAP_ANONYMOUS | extra_flags, -1, 0);
  return block == MAP_FAILED ? nullptr : block;
}

// One write to each page makes it present; the pages are zero already.
void touch_pages(void* block, std::size_t bytes) noexcept {
  auto* first = static_cast<volatile char*>(block);
  for (std::size_t i = 0; i < bytes; i += kSmallestPageBytes) first[i] = 0;
}

}  // namespace

Arena::~Arena() {
  if (mapping_ != nullptr) ::munmap(mapping_, mapped_bytes_);
}

Arena::Arena(Arena&& other) noexcept {
  swap(other);
}

Arena& Arena::operator=(Arena&& other) noexcept {
  Arena moved(std::move(other));
  swap(moved);
  return *this;
}

Arena Arena::measuring() noexcept {
  Arena arena;
  arena.measuring_ = true;
  return arena;
}

Result<Arena> Arena::map(std::size_t bytes, ArenaOptions options) {
  Arena arena;
  if (bytes == 0) return arena;
  if (!arena.map_block(bytes, options.huge_pages)) {
    return {Status::kOutOfArena, "arena: the system refuses to map " + std::to_string(bytes) +
                                     " bytes (" + std::strerror(errno) +
                                     "); use fewer slots or a smaller max_points"};
  }
  if (options.lock) arena.lock_refused_ = ::mlock(arena.mapping_, arena.mapped_bytes_) != 0;
  arena.block_ = {static_cast<std::byte*>(arena.mapping_), bytes};
  return arena;
}

Result<Arena> Arena::over(std::span<std::byte> block) {
  if (std::bit_cast<std::uintptr_t>(block.data()) % kMaxAlign != 0) {
    return {Status::kBadConfig, "arena: the given block must start on a multiple of " +
                                    std::to_string(kMaxAlign) +
                                    " bytes; allocate it with std::aligned_alloc or alignas"};
  }
  Arena arena;
  arena.block_ = block;
  return arena;
}

// Reserved huge pages first; else transparent ones, which must be asked for before the pages are
// touched and are granted only as the kernel sees fit; else ordinary pages.
bool Arena::map_block(std::size_t bytes, bool huge_pages) noexcept {
  if (bytes > std::numeric_limits<std::size_t>::max() - kHugePageBytes) {
    errno = ENOMEM;
    return false;
  }
  if (!huge_pages) {
    mapped_bytes_ = bytes;
    mapping_ = map_anonymous(bytes, MAP_POPULATE);
    return mapping_ != nullptr;
  }
  mapped_bytes_ = (bytes + kHugePageBytes - 1) / kHugePageBytes * kHugePageBytes;
  mapping_ = map_anonymous(mapped_bytes_, MAP_HUGETLB | MAP_POPULATE);
  if (mapping_ != nullptr) return true;
  mapping_ = map_anonymous(mapped_bytes_, 0);
  if (mapping_ == nullptr) return false;
  huge_pages_refused_ = ::madvise(mapping_, mapped_bytes_, MADV_HUGEPAGE) != 0;
  touch_pages(mapping_, mapped_bytes_);
  return true;
}

// needed_ keeps growing after a failure, so that a message can name the size that would do, and so
// that no later, smaller take can succeed behind the back of a failed one.
std::byte* Arena::carve(std::size_t n, std::size_t size, std::size_t align) noexcept {
  constexpr std::size_t kMost = std::numeric_limits<std::size_t>::max();
  const bool bad_align = !std::has_single_bit(align) || align > kMaxAlign;
  if (sealed_ || bad_align || n > kMost / size || needed_ > kMost - align) {
    failed_ = true;
    return nullptr;
  }
  const std::size_t start = (needed_ + align - 1) / align * align;
  if (n * size > kMost - start) {
    failed_ = true;
    return nullptr;
  }
  needed_ = start + n * size;
  if (measuring_) return nullptr;
  if (needed_ > block_.size()) {
    failed_ = true;
    return nullptr;
  }
  used_ = needed_;
  return block_.data() + start;
}

void Arena::swap(Arena& other) noexcept {
  std::swap(block_, other.block_);
  std::swap(mapping_, other.mapping_);
  std::swap(mapped_bytes_, other.mapped_bytes_);
  std::swap(needed_, other.needed_);
  std::swap(used_, other.used_);
  std::swap(measuring_, other.measuring_);
  std::swap(sealed_, other.sealed_);
  std::swap(failed_, other.failed_);
  std::swap(lock_refused_, other.lock_refused_);
  std::swap(huge_pages_refused_, other.huge_pages_refused_);
}

}  // namespace planecast
