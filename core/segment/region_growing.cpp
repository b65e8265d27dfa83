#include "core/segment/region_growing.hpp"

#include <algorithm>
#include <array>

namespace planecast {
namespace {

constexpr std::uint16_t kGivenUp = 0xffff;
constexpr std::uint32_t kMaxRegions = 1024;  // before the largest are kept
constexpr std::uint32_t kKeptSums = 128;
constexpr std::uint32_t kBuckets = 256;
// One surface for two regions may add this much to the mean squared residual of the smaller one, in
// noise variances: a share of what it has, and a constant. What lies apart is held to less.
constexpr double kMergeShare = 0.3, kMergeSlack = 0.15, kApartSlack = 0.15;
// A surface of degree two must hold this many more cells than the plane, or leave this share of its
// residual: three more coefficients are never free.
constexpr double kCurvedGrowth = 1.25, kCurvedGain = 0.7;
constexpr std::uint32_t kCurvedCells = 12;
// What three more coefficients take off the squared residuals of a plane by following shared noise:
// a share of them, something of every reading, and a constant.
constexpr double kFlatShare = 0.05, kFlatSlack = 0.03, kFlatConstant = 100;
constexpr double kCurvedMerge = 0.5;  // of what a plane may add when it takes in another

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

// Neighbours of each label as bits; one cell between two regions does not part them.
struct RegionGrowing::Adjacency {
  std::array<std::uint64_t, kMaxSurfaces + 1> touches{};

  bool touch(unsigned a, unsigned b) const noexcept {
    return ((touches[a] >> b) & 1U) != 0 || ((touches[b] >> a) & 1U) != 0;
  }
};

void RegionGrowing::layout(Arena& arena, std::uint32_t max_width,
                           std::uint32_t max_height) noexcept {
  const std::size_t cells = std::size_t{(max_width + 7) / 8} * ((max_height + 7) / 8);
  order_ = arena.take<std::uint32_t>(cells);
  queue_ = arena.take<std::uint32_t>(cells);
  mark_ = arena.take<std::uint16_t>(cells);
  labels_ = arena.take<std::uint8_t>(cells);
  regions_ = arena.take<Region>(kMaxRegions);
  quadrics_ = arena.take<QuadricSums>(kMaxSurfaces + 1);
  grown_ = arena.take<QuadricSums>(kKeptSums);
}

Status RegionGrowing::process(const CellGrid& grid, const GrowingOptions& options,
                              RegionMap& out) noexcept {
  const std::span<const Cell> cells = grid.cells();
  out = {};
  if (cells.size() > mark_.size()) return Status::kFrameTooLarge;
  std::fill_n(mark_.begin(), cells.size(), std::uint16_t{0});
  region_count_ = 0;
  grown_count_ = 0;
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
  std::uint64_t curved = 0;
  for (std::uint32_t i = 0; i < region_count_; ++i) {
    const Region& region = regions_[i];
    regions = std::max<int>(regions, region.final_label);
    if (region.joined == nullptr && region.final_label != 0 && region.surface.curved()) {
      curved |= std::uint64_t{1} << region.final_label;
    }
  }
  out = {grid.cells_wide(),  grid.cells_high(), cells, labels_.first(cells.size()), regions, curved,
         grid.noise_factor()};
  return Status::kOk;
}

// Counting sort by residual: linear, and stable, so that equal cells keep the order of the image.
void RegionGrowing::order_seeds(const CellGrid& grid, double threshold) noexcept {
  const std::span<const Cell> cells = grid.cells();
  const auto scale = static_cast<float>(kBuckets / threshold);
  const auto bucket = [&](const Cell& cell) {
    return std::min(static_cast<std::uint32_t>(cell.own / cell.variance * scale), kBuckets - 1);
  };
  const auto seed = [&](const Cell& cell) {
    return cell.flat && cell.own < static_cast<float>(threshold) * cell.variance;
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
  const auto accept = static_cast<float>(options.accept_sigmas * options.accept_sigmas);
  Region region;
  region.sums = plane_sums(cells[seed]);
  region.readings = double{cells[seed].n};
  if (!region.sums.solve(region.surface)) {
    mark_[seed] = kGivenUp;
    return;
  }
  queue_[0] = seed;
  mark_[seed] = static_cast<std::uint16_t>(region_count_ + 1);
  region.cells = spread(grid, region, 0, 1, accept, true);
  if (region.cells < options.min_cells) {
    for (std::uint32_t i = 0; i < region.cells; ++i) mark_[queue_[i]] = kGivenUp;
    return;
  }
  (void)region.sums.solve(region.surface);
  region.squares = region.sums.mean_square(region.surface) * region.sums.n;
  if (options.curved && region.cells >= kCurvedCells) try_curved(grid, region, options);
  regions_[region_count_++] = region;
}

// Takes cells next to queue_[head, tail) that lie on the region's surface, and those next to them;
// returns the new tail. `refit`: the region is a plane that follows what it takes in.
std::uint32_t RegionGrowing::spread(const CellGrid& grid, Region& region, std::uint32_t head,
                                    std::uint32_t tail, float accept, bool refit) noexcept {
  const std::span<const Cell> cells = grid.cells();
  const auto id = static_cast<std::uint16_t>(region_count_ + 1);
  std::uint32_t since_fit = 0;
  for (; head < tail; ++head) {
    const Around around = neighbours(queue_[head], grid.cells_wide(), grid.cells_high());
    for (int i = 0; i < around.count; ++i) {
      const std::uint32_t next = around.cell[i];
      const Cell& cell = cells[next];
      if (mark_[next] != 0 || !cell.usable) continue;
      if (!(cell_residual(cell, region.surface) < accept)) continue;
      mark_[next] = id;
      queue_[tail++] = next;
      region.sums.add(plane_sums(cell));
      region.readings += double{cell.n};
      if (refit && ++since_fit >= std::max(4U, tail / 4)) {
        (void)region.sums.solve(region.surface);
        since_fit = 0;
      }
    }
  }
  return tail;
}

// A region that a plane cannot follow any further may be part of something round: degree two is
// fitted, grown on, and kept when it holds much more or fits much better.
void RegionGrowing::try_curved(const CellGrid& grid, Region& region,
                               const GrowingOptions& options) noexcept {
  const std::span<const Cell> cells = grid.cells();
  QuadricSums sums;
  for (std::uint32_t i = 0; i < region.cells; ++i) add_cell(sums, cells[queue_[i]]);
  const QuadricSums flat = sums;
  Region curved = region;
  double mean_square = 0;
  if (!sums.solve(curved.surface, mean_square)) return;
  const bool fits_better =
      mean_square * sums.n < kCurvedGain * region.squares && region.squares > 0.5 * region.readings;
  const auto accept = static_cast<float>(options.accept_sigmas * options.accept_sigmas);
  curved.cells = spread(grid, curved, 0, region.cells, accept, false);
  for (std::uint32_t i = region.cells; i < curved.cells; ++i) add_cell(sums, cells[queue_[i]]);
  if ((fits_better || curved.cells >= kCurvedGrowth * region.cells) &&
      sums.solve(curved.surface, mean_square)) {
    region = curved;
    region.squares = mean_square * sums.n;
    keep_sums(region, sums);
    prefer_plane(region);
    return;
  }
  for (std::uint32_t i = region.cells; i < curved.cells; ++i) mark_[queue_[i]] = 0;
  keep_sums(region, flat);
}

// Merging asks for them again.
void RegionGrowing::keep_sums(Region& region, const QuadricSums& sums) noexcept {
  if (grown_count_ == grown_.size()) return;
  grown_[grown_count_] = sums;
  region.kept_sums = ++grown_count_;
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
  Adjacency adjacent;
  std::array<Region*, kMaxSurfaces + 1> of{};
  for (std::uint32_t i = 0; i < region_count_; ++i) of[regions_[i].final_label] = &regions_[i];
  of[0] = nullptr;
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
        if (x + step < wide) adjacent.touches[here] |= std::uint64_t{1} << label_at(x + step, y);
        if (y + step < high) adjacent.touches[here] |= std::uint64_t{1} << label_at(x, y + step);
      }
    }
  }
  if (options.curved) sum_quadrics(grid);
  // Large ones first: what they take in has the least say in where they lie.
  for (const bool curved : {false, true}) {
    if (curved && !options.curved) break;
    for (unsigned a = 1; a <= kMaxSurfaces && of[a] != nullptr; ++a) {
      for (unsigned b = a + 1; b <= kMaxSurfaces && of[b] != nullptr; ++b) {
        Region& first = *root(of[a]);
        Region& second = *root(of[b]);
        if (&first == &second) continue;
        const bool touch = adjacent.touch(a, b);
        if (curved ? touch && merge_curved(first, second) : merge_planes(first, second, touch)) {
          second.joined = &first;
        }
      }
    }
  }
  number_again();
}

void RegionGrowing::sum_quadrics(const CellGrid& grid) noexcept {
  const std::span<const Cell> cells = grid.cells();
  std::fill(quadrics_.begin(), quadrics_.end(), QuadricSums{});
  for (std::uint32_t i = 0; i < region_count_; ++i) {
    const Region& region = regions_[i];
    if (region.kept_sums != 0) quadrics_[region.final_label] = grown_[region.kept_sums - 1U];
  }
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (mark_[i] == 0 || mark_[i] == kGivenUp) continue;
    const Region& region = regions_[mark_[i] - 1U];
    if (region.kept_sums == 0 && region.final_label != 0)
      add_cell(quadrics_[region.final_label], cells[i]);
  }
}

// Takes `second` into `first` when one plane explains both.
bool RegionGrowing::merge_planes(Region& first, Region& second, bool touch) noexcept {
  if (first.surface.curved() || second.surface.curved()) return false;
  Region both = first;
  both.sums.add(second.sums);
  if (!both.sums.solve(both.surface)) return false;
  both.squares = both.sums.mean_square(both.surface) * both.sums.n;
  const Region& smaller = first.readings < second.readings ? first : second;
  const double allowed = touch ? kMergeShare * smaller.squares + kMergeSlack * smaller.readings
                               : kApartSlack * smaller.readings;
  if (both.squares - first.squares - second.squares > allowed) return false;
  both.readings += second.readings;
  both.cells += second.cells;
  quadrics_[first.final_label].add(quadrics_[second.final_label]);
  first = both;
  return true;
}

// The same with a surface of degree two.
bool RegionGrowing::merge_curved(Region& first, Region& second) noexcept {
  QuadricSums sums = quadrics_[first.final_label];
  sums.add(quadrics_[second.final_label]);
  FloatSurface surface;
  double mean_square = 0;
  if (!sums.solve(surface, mean_square)) return false;
  const Region& smaller = first.readings < second.readings ? first : second;
  const double squares = mean_square * sums.n;
  if (squares - first.squares - second.squares >
      kCurvedMerge * (kMergeShare * smaller.squares + kMergeSlack * smaller.readings)) {
    return false;
  }
  first.surface = surface;
  first.squares = squares;
  first.sums.add(second.sums);
  first.readings += second.readings;
  first.cells += second.cells;
  quadrics_[first.final_label] = sums;
  prefer_plane(first);
  return true;
}

// Makes a region of degree two a plane where that explains it nearly as well.
void RegionGrowing::prefer_plane(Region& region) noexcept {
  FloatSurface plane;
  if (!region.sums.solve(plane)) return;
  const double squares = region.sums.mean_square(plane) * region.sums.n;
  if (squares - region.squares >
      kFlatShare * region.squares + kFlatSlack * region.readings + kFlatConstant) {
    return;
  }
  region.surface = plane;
  region.squares = squares;
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
