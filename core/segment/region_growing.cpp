#include "core/segment/region_growing.hpp"

#include <algorithm>
#include <array>

namespace planecast {
namespace {

constexpr std::uint16_t kGivenUp = 0xffff;
constexpr std::uint32_t kMaxRegions = 1024;  // before the largest are kept
constexpr std::uint32_t kBuckets = 256;
// One plane for two regions may cost this much residual over one each.
constexpr double kMergeLoss = 1.3;
constexpr double kMergeSlack = 0.1;

struct Around {
  std::uint32_t cell[4];
  int count = 0;
};

Around neighbours(std::uint32_t cell, std::uint32_t wide, std::uint32_t high) noexcept {
  const std::uint32_t x = cell % wide, y = cell / wide;
  Around out;
  if (x > 0) out.cell[out.count++] = cell - 1;
  if (x + 1 < wide) out.cell[out.count++] = cell + 1;
  if (y > 0) out.cell[out.count++] = cell - wide;
  if (y + 1 < high) out.cell[out.count++] = cell + wide;
  return out;
}

}  // namespace

void RegionGrowing::layout(Arena& arena, std::uint32_t max_width,
                           std::uint32_t max_height) noexcept {
  const std::size_t cells = std::size_t{(max_width + 7) / 8} * ((max_height + 7) / 8);
  order_ = arena.take<std::uint32_t>(cells);
  queue_ = arena.take<std::uint32_t>(cells);
  mark_ = arena.take<std::uint16_t>(cells);
  labels_ = arena.take<std::uint8_t>(cells);
  regions_ = arena.take<Region>(kMaxRegions);
}

Status RegionGrowing::process(const CellGrid& grid, const GrowingOptions& options,
                              RegionMap& out) noexcept {
  const std::span<const Cell> cells = grid.cells();
  out = {};
  if (cells.size() > mark_.size()) return Status::kFrameTooLarge;
  std::fill_n(mark_.begin(), cells.size(), std::uint16_t{0});
  region_count_ = 0;
  order_seeds(grid, options.seed_sigmas * options.seed_sigmas);
  for (std::uint32_t i = 0; i < seeds_ && region_count_ < kMaxRegions; ++i) {
    if (mark_[order_[i]] == 0) grow(grid, order_[i], options);
  }
  keep_largest();
  merge(grid, options);
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const bool labelled = mark_[i] != 0 && mark_[i] != kGivenUp;
    labels_[i] = labelled ? static_cast<std::uint8_t>(regions_[mark_[i] - 1U].final_label) : 0;
  }
  int regions = 0;
  for (std::uint32_t i = 0; i < region_count_; ++i) {
    regions = std::max<int>(regions, regions_[i].final_label);
  }
  out = {grid.cells_wide(), grid.cells_high(), cells, labels_.first(cells.size()), regions};
  return Status::kOk;
}

// Counting sort by residual: linear, and stable, so that equal cells keep the order of the image.
void RegionGrowing::order_seeds(const CellGrid& grid, double threshold) noexcept {
  const std::span<const Cell> cells = grid.cells();
  const auto scale = static_cast<float>(kBuckets / threshold);
  const auto bucket = [&](const Cell& cell) {
    return std::min(static_cast<std::uint32_t>(cell.own_residual * scale), kBuckets - 1);
  };
  const auto seed = [&](const Cell& cell) {
    return cell.flat && cell.own_residual < static_cast<float>(threshold);
  };
  std::array<std::uint32_t, kBuckets + 1> start{};
  for (const Cell& cell : cells) {
    if (seed(cell)) ++start[bucket(cell) + 1];
  }
  for (std::uint32_t i = 0; i < kBuckets; ++i) start[i + 1] += start[i];
  seeds_ = start[kBuckets];
  for (std::uint32_t i = 0; i < cells.size(); ++i) {
    if (seed(cells[i])) order_[start[bucket(cells[i])]++] = i;
  }
}

void RegionGrowing::grow(const CellGrid& grid, std::uint32_t seed,
                         const GrowingOptions& options) noexcept {
  const std::span<const Cell> cells = grid.cells();
  const double accept = options.accept_sigmas * options.accept_sigmas;
  const auto id = static_cast<std::uint16_t>(region_count_ + 1);
  Region region;
  region.sums.add(cells[seed].sums, 1.0 / cells[seed].variance);
  region.readings = cells[seed].sums.n;
  if (!region.sums.solve(region.plane)) {
    mark_[seed] = kGivenUp;
    return;
  }
  std::uint32_t tail = 0, since_fit = 0;
  queue_[tail++] = seed;
  mark_[seed] = id;
  for (std::uint32_t head = 0; head < tail; ++head) {
    const Around around = neighbours(queue_[head], grid.cells_wide(), grid.cells_high());
    for (int i = 0; i < around.count; ++i) {
      const std::uint32_t next = around.cell[i];
      const Cell& cell = cells[next];
      if (mark_[next] != 0 || !cell.usable) continue;
      if (!(cell.sums.mean_square(region.plane) < accept * cell.variance)) continue;
      mark_[next] = id;
      queue_[tail++] = next;
      region.sums.add(cell.sums, 1.0 / cell.variance);
      region.readings += cell.sums.n;
      if (++since_fit >= std::max(4U, tail / 4)) {
        (void)region.sums.solve(region.plane);
        since_fit = 0;
      }
    }
  }
  if (tail < options.min_cells) {
    for (std::uint32_t i = 0; i < tail; ++i) mark_[queue_[i]] = kGivenUp;
    return;
  }
  (void)region.sums.solve(region.plane);
  region.cells = tail;
  regions_[region_count_++] = region;
}

// Labels 1 .. kMaxSurfaces for the largest regions, first found first among equals; 0 for others.
void RegionGrowing::keep_largest() noexcept {
  const std::uint32_t wanted = std::min(region_count_, static_cast<std::uint32_t>(kMaxSurfaces));
  for (std::uint32_t label = 1; label <= wanted; ++label) {
    Region* largest = nullptr;
    for (std::uint32_t i = 0; i < region_count_; ++i) {
      Region& region = regions_[i];
      if (region.final_label == 0 && (largest == nullptr || region.cells > largest->cells)) {
        largest = &region;
      }
    }
    largest->final_label = static_cast<std::uint16_t>(label);
  }
}

void RegionGrowing::merge(const CellGrid& grid, const GrowingOptions& options) noexcept {
  // Neighbours of each label, as bits; one cell between two regions does not part them.
  std::array<std::uint64_t, kMaxSurfaces + 1> touches{};
  std::array<Region*, kMaxSurfaces + 1> of{};
  for (std::uint32_t i = 0; i < region_count_; ++i) of[regions_[i].final_label] = &regions_[i];
  const std::uint32_t wide = grid.cells_wide(), high = grid.cells_high();
  const auto label_at = [&](std::uint32_t x, std::uint32_t y) -> unsigned {
    const std::uint16_t mark = mark_[std::size_t{y} * wide + x];
    return mark == 0 || mark == kGivenUp ? 0U : regions_[mark - 1U].final_label;
  };
  for (std::uint32_t y = 0; y < high; ++y) {
    for (std::uint32_t x = 0; x < wide; ++x) {
      const unsigned here = label_at(x, y);
      if (here == 0) continue;
      for (std::uint32_t step = 1; step <= 2; ++step) {
        if (x + step < wide) touches[here] |= std::uint64_t{1} << label_at(x + step, y);
        if (y + step < high) touches[here] |= std::uint64_t{1} << label_at(x, y + step);
      }
    }
  }
  const double most = options.accept_sigmas * options.accept_sigmas;
  for (unsigned a = 1; a <= kMaxSurfaces; ++a) {
    for (unsigned b = a + 1; b <= kMaxSurfaces; ++b) {
      if (((touches[a] >> b) & 1U) == 0 && ((touches[b] >> a) & 1U) == 0) continue;
      Region& first = *root(of[a]);
      Region& second = *root(of[b]);
      if (&first == &second) continue;
      Region both = first;
      both.sums.add(second.sums);
      both.readings += second.readings;
      both.cells += second.cells;
      if (!both.sums.solve(both.plane)) continue;
      const double apart =
          (first.residual() * first.readings + second.residual() * second.readings) / both.readings;
      if (both.residual() > std::min(most, kMergeLoss * apart + kMergeSlack)) continue;
      first = both;
      second.joined = &first;
    }
  }
  number_again();
}

RegionGrowing::Region* RegionGrowing::root(Region* region) noexcept {
  while (region->joined != nullptr) region = region->joined;
  return region;
}

// Closes the gaps that joined regions left in the labels.
void RegionGrowing::number_again() noexcept {
  std::array<std::uint16_t, kMaxSurfaces + 1> number{};
  for (std::uint32_t i = 0; i < region_count_; ++i) {
    if (regions_[i].joined == nullptr) number[regions_[i].final_label] = 1;
  }
  number[0] = 0;
  std::uint16_t last = 0;
  for (std::uint16_t& n : number) n = n != 0 ? ++last : std::uint16_t{0};
  for (std::uint32_t i = 0; i < region_count_; ++i) {
    Region& region = regions_[i];
    if (region.joined == nullptr) region.final_label = number[region.final_label];
  }
  for (std::uint32_t i = 0; i < region_count_; ++i) {
    regions_[i].final_label = root(&regions_[i])->final_label;
  }
}

}  // namespace planecast
