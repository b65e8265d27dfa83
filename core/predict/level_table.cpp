#include "core/predict/level_table.hpp"

namespace planecast {
namespace {

constexpr std::uint32_t kCounts = 65536;

std::uint32_t floor_sqrt(std::uint64_t value) noexcept {
  std::uint64_t root = 0;
  for (std::uint64_t bit = std::uint64_t{1} << 31U; bit != 0; bit >>= 1U) {
    const std::uint64_t next = root + bit;
    if (next * next <= value) root = next;
  }
  return static_cast<std::uint32_t>(root);
}

}  // namespace

void LevelTable::layout(Arena& arena) noexcept {
  depth_ = arena.take<std::uint16_t>(kCounts);
  nearest_ = arena.take<std::uint16_t>(kCounts);
}

Status LevelTable::build(const Lattice& lattice) noexcept {
  lattice_ = lattice;
  count_ = 1;
  depth_[0] = 0;
  // Nearer than sqrt(C) the spacing of the lattice is below one count: every count is a level.
  std::uint32_t dense = kCounts - 1;
  if (lattice.present()) {
    if (lattice.c_q8 < kMinLatticeCQ8) return Status::kFieldRange;
    dense = floor_sqrt(lattice.c_q8 >> 8U);
    if (dense > kCounts - 1) dense = kCounts - 1;
  }
  while (count_ <= dense) {
    depth_[count_] = static_cast<std::uint16_t>(count_);
    ++count_;
  }
  std::uint32_t last_k = 0;
  if (lattice.present()) {
    const std::uint64_t first_k = (lattice.c_q8 >> 8U) / dense + 1;
    for (std::uint64_t k = first_k; k >= 1; --k) {
      const std::uint64_t depth = lattice_depth(lattice, k);
      if (depth <= depth_[count_ - 1]) continue;
      if (depth >= kCounts || count_ >= kCounts) break;
      depth_[count_++] = static_cast<std::uint16_t>(depth);
      last_k = static_cast<std::uint32_t>(k);
    }
  }
  const std::uint64_t from_q8 = std::uint64_t{last_k == 0 ? kCounts : dense} * 256;
  lattice_most_iv_ = static_cast<std::int64_t>(kOneQ8 / (from_q8 + 1));
  top_q8_ =
      std::int64_t{count_ - 1} * 256 + std::int64_t{last_k} * 256 + (lattice.offset_q16 >> 8U);

  nearest_[0] = 0;
  std::uint32_t level = 1;
  for (std::uint32_t depth = 1; depth < kCounts; ++depth) {
    while (level + 1 < count_ &&
           std::uint32_t{depth_[level + 1]} - depth <= depth - depth_[level] &&
           depth >= depth_[level]) {
      ++level;
    }
    nearest_[depth] = static_cast<std::uint16_t>(level);
  }
  return Status::kOk;
}

}  // namespace planecast
