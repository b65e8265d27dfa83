#include "core/fit/region_refine.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "core/fit/curved_regions.hpp"
#include "core/model/cell_moments.hpp"

namespace planecast {
namespace {

// What a neighbour in another region adds to a cell's residual: borders run straight where the
// readings do not say otherwise.
constexpr float kBorder = 1;
constexpr int kRounds = 2;  // of cells and fits settling on each other
// Of cells that no region holds: residual from their own plane and of 3 x 3 of them from a common
// one for a region to start there, the flattest first; and from its plane to be taken in.
constexpr float kSeedCell = 3, kSeedGroup = 2.5F, kFlatGroup = 1.5F, kGrow = 4;
constexpr int kSeedCells = 3;
// Cells of a region that starts there. Large ones come first, while labels last; small ones are
// parts of narrow faces, which join() puts together. Those cost more in coefficients and labels
// than they save where what lies on no surface is coded all the same.
constexpr std::uint32_t kLargeCells = 30, kLeastCells = 10;
// What one plane for two regions may add to the squared residuals: a constant, since neighbouring
// pixels share noise, and a share of the smaller one's readings, since no sensor is free of bias.
constexpr double kJoinConstant = 360, kJoinShare = 0.2;
constexpr std::uint8_t kGivenUp = 255;
constexpr double kRayOne = 0x1p-27;

bool is_curved(const RegionMap& map, unsigned label) noexcept {
  return ((map.curved >> label) & 1U) != 0;
}

// A region's clean cells.
struct CleanSums {
  PlaneSums plane;
  QuadricSums quadric;
  double readings = 0;
  std::uint32_t cells = 0;  ///< clean or not
  float least_variance = 0;
};

void solve(const CleanSums& sums, bool curved, RegionFit& fit) noexcept {
  fit.cells = sums.cells;
  fit.readings = sums.readings;
  fit.min_sigma = std::sqrt(double{sums.least_variance});
  FloatSurface surface;
  double mean_square = 0;
  if (curved && sums.quadric.solve(surface, mean_square)) {
    fit.valid = true;
    fit.residual = mean_square * sums.quadric.n / sums.readings;
  } else if (sums.plane.solve(surface)) {
    fit.valid = true;
    fit.residual = sums.plane.mean_square(surface) * sums.plane.n / sums.readings;
  } else {
    fit.valid = false;
    return;
  }
  fit.surface = surface;
}

}  // namespace

void RegionRefiner::layout(Arena& arena, std::uint32_t max_width,
                           std::uint32_t max_height) noexcept {
  const std::size_t cells = std::size_t{fine_cells(max_width)} * fine_cells(max_height);
  cells_ = arena.take<Cell>(cells);
  labels_ = arena.take<std::uint8_t>(cells);
  queue_ = arena.take<std::uint32_t>(cells);
}

const RegionMap& RegionRefiner::process(const FitTables& tables,
                                        std::span<const std::uint16_t> depth,
                                        const RegionMap& coarse,
                                        std::span<RegionFit> fits) noexcept {
  const std::uint32_t wide = fine_cells(tables.rays->width);
  const std::uint32_t high = fine_cells(tables.rays->height);
  const std::size_t cells = std::size_t{wide} * high;
  measure_fine_cells(tables, depth, coarse.noise_factor, cells_.first(cells));
  map_ = {wide,           high,          cells_.first(cells), labels_.first(cells),
          coarse.regions, coarse.curved, coarse.noise_factor};
  inherit(coarse);
  for (int round = 0; round < kRounds; ++round) {
    settle(fits);
    fit(fits);
  }
  leave_rest(tables, depth, fits);
  const bool drop = tables.config->drop_off_surface;
  discover(kLargeCells, fits);
  if (drop) discover(kLeastCells, fits);
  fit(fits);
  settle(fits);
  fit(fits);
  (void)flatten_curved(map_, fits, queue_);
  join(fits);
  settle(fits);
  fit(fits);
  return map_;
}

void RegionRefiner::inherit(const RegionMap& coarse) noexcept {
  for (std::uint32_t y = 0; y < map_.cells_high; ++y) {
    for (std::uint32_t x = 0; x < map_.cells_wide; ++x) {
      const std::size_t i = std::size_t{y} * map_.cells_wide + x;
      const std::size_t from = std::size_t{y / 2} * coarse.cells_wide + x / 2;
      labels_[i] = cells_[i].usable ? coarse.labels[from] : std::uint8_t{0};
    }
  }
}

// Fits every region to those of its cells that lie on the surface it had.
void RegionRefiner::fit(std::span<RegionFit> fits) const noexcept {
  std::array<CleanSums, kMaxSurfaces + 1> all{};
  for (std::size_t i = 0; i < map_.labels.size(); ++i) {
    const unsigned label = labels_[i];
    if (label == 0) continue;
    const Cell& cell = cells_[i];
    const RegionFit& had = fits[label - 1];
    CleanSums& sums = all[label];
    if (sums.cells++ == 0 || cell.variance < sums.least_variance)
      sums.least_variance = cell.variance;
    if (had.valid && cell_residual(cell, had.surface) > kCleanResidual) continue;
    sums.plane.add(plane_sums(cell));
    if (is_curved(map_, label)) add_cell(sums.quadric, cell);
    sums.readings += double{cell.n};
  }
  for (int k = 1; k <= map_.regions; ++k)
    solve(all[k], is_curved(map_, static_cast<unsigned>(k)), fits[k - 1]);
}

// A cell with none but its own label around, which may be none.
bool RegionRefiner::is_inside(std::uint32_t x, std::uint32_t y) const noexcept {
  const std::uint32_t wide = map_.cells_wide;
  if (x == 0 || y == 0 || x + 1 == wide || y + 1 == map_.cells_high) return false;
  const std::uint8_t* here = &labels_[std::size_t{y} * wide + x];
  const auto row = [](const std::uint8_t* at) { return at[-1] | at[0] << 8 | at[1] << 16; };
  const int three = *here * 0x010101;
  return row(here - wide) == three && row(here) == three && row(here + wide) == three;
}

// Gives every cell the label that fits it and its neighbours best.
void RegionRefiner::settle(std::span<const RegionFit> fits) noexcept {
  for (std::uint32_t y = 0; y < map_.cells_high; ++y) {
    for (std::uint32_t x = 0; x < map_.cells_wide; ++x) {
      const std::size_t i = std::size_t{y} * map_.cells_wide + x;
      if (!cells_[i].usable) continue;
      if (!is_inside(x, y)) {
        labels_[i] = best_label(x, y, fits);
      } else if (labels_[i] != 0) {  // nothing else is on offer
        const RegionFit& fit = fits[labels_[i] - 1U];
        const bool holds = fit.valid && cell_residual(cells_[i], fit.surface) < kMostCellResidual;
        if (!holds) labels_[i] = 0;
      }
    }
  }
}

RegionRefiner::LabelSet RegionRefiner::labels_around(std::uint32_t x,
                                                     std::uint32_t y) const noexcept {
  LabelSet out;
  const std::uint32_t wide = map_.cells_wide;
  out.add(labels_[std::size_t{y} * wide + x]);
  for (std::uint32_t v = y > 0 ? y - 1 : 0; v <= std::min(y + 1, map_.cells_high - 1); ++v) {
    for (std::uint32_t u = x > 0 ? x - 1 : 0; u <= std::min(x + 1, wide - 1); ++u)
      out.add(labels_[std::size_t{v} * wide + u]);
  }
  return out;
}

std::uint8_t RegionRefiner::best_label(std::uint32_t x, std::uint32_t y,
                                       std::span<const RegionFit> fits) const noexcept {
  const std::uint32_t wide = map_.cells_wide;
  const std::size_t i = std::size_t{y} * wide + x;
  const std::uint8_t beside[4] = {x > 0 ? labels_[i - 1] : std::uint8_t{0},
                                  x + 1 < wide ? labels_[i + 1] : std::uint8_t{0},
                                  y > 0 ? labels_[i - wide] : std::uint8_t{0},
                                  y + 1 < map_.cells_high ? labels_[i + wide] : std::uint8_t{0}};
  const LabelSet offers = labels_around(x, y);
  std::uint8_t best = 0;
  float least = kMostCellResidual;
  for (int k = 0; k < offers.count; ++k) {
    const std::uint8_t label = offers.label[k];
    if (!fits[label - 1U].valid) continue;
    float energy = cell_residual(cells_[i], fits[label - 1U].surface);
    for (const std::uint8_t other : beside) energy += other != 0 && other != label ? kBorder : 0;
    if (energy >= least) continue;
    least = energy;
    best = label;
  }
  return best;
}

// The plane of the flat cells without a region around a cell, where they lie on one.
bool RegionRefiner::seed_plane(std::uint32_t x, std::uint32_t y, float limit,
                               FloatSurface& plane) const noexcept {
  const auto flat = [&](std::size_t i) {
    return labels_[i] == 0 && cells_[i].usable && cells_[i].own <= kSeedCell * cells_[i].variance;
  };
  if (!flat(std::size_t{y} * map_.cells_wide + x)) return false;
  PlaneSums sums;
  double readings = 0;
  int cells = 0;
  for (std::uint32_t v = y - 1; v <= y + 1; ++v) {
    for (std::uint32_t u = x - 1; u <= x + 1; ++u) {
      const std::size_t i = std::size_t{v} * map_.cells_wide + u;
      if (!flat(i)) continue;
      sums.add(plane_sums(cells_[i]));
      readings += double{cells_[i].n};
      ++cells;
    }
  }
  return cells >= kSeedCells && sums.solve(plane) &&
         sums.mean_square(plane) * sums.n <= double{limit} * readings;
}

// Takes cells without a region, in all eight directions: narrow faces lie askew. Returns how many;
// they are in queue_.
std::uint32_t RegionRefiner::grow(std::uint32_t seed, FloatSurface& plane,
                                  std::uint8_t label) noexcept {
  const std::uint32_t wide = map_.cells_wide, high = map_.cells_high;
  std::uint32_t tail = 0, since_fit = 0;
  PlaneSums sums;
  const auto take = [&](std::uint32_t cell) {
    labels_[cell] = label;
    queue_[tail++] = cell;
    sums.add(plane_sums(cells_[cell]));
  };
  take(seed);
  for (std::uint32_t head = 0; head < tail; ++head) {
    const std::uint32_t x = queue_[head] % wide, y = queue_[head] / wide;
    for (std::uint32_t v = y > 0 ? y - 1 : 0; v <= std::min(y + 1, high - 1); ++v) {
      for (std::uint32_t u = x > 0 ? x - 1 : 0; u <= std::min(x + 1, wide - 1); ++u) {
        const std::uint32_t next = v * wide + u;
        if (labels_[next] != 0 || !cells_[next].usable) continue;
        if (cell_residual(cells_[next], plane) > kGrow) continue;
        take(next);
        if (++since_fit < std::max(6U, tail / 4)) continue;
        (void)sums.solve(plane);
        since_fit = 0;
      }
    }
  }
  (void)sums.solve(plane);
  return tail;
}

// Cells without a region keep only the readings that lie on no surface around them: what is
// narrower than a cell stands out so.
void RegionRefiner::leave_rest(const FitTables& tables, std::span<const std::uint16_t> depth,
                               std::span<const RegionFit> fits) noexcept {
  const RayTable& rays = *tables.rays;
  for (std::uint32_t y = 0; y < map_.cells_high; ++y) {
    for (std::uint32_t x = 0; x < map_.cells_wide; ++x) {
      const std::size_t i = std::size_t{y} * map_.cells_wide + x;
      if (labels_[i] != 0 || cells_[i].n == 0) continue;
      const LabelSet around = labels_around(x, y);
      const std::uint32_t u0 = x * kFineSide, v0 = y * kFineSide;
      const std::uint32_t readings = cell_readings(rays, depth, u0, v0);
      const float most = kMostCellResidual * cells_[i].variance;
      std::uint32_t rest = readings;
      for (std::uint32_t left = readings; left != 0; left &= left - 1) {
        const auto bit = static_cast<std::uint32_t>(std::countr_zero(left));
        const std::uint32_t u = u0 + bit % kFineSide, v = v0 + bit / kFineSide;
        const double w = double{kInverseDepthOne} / depth[std::size_t{v} * rays.width + u];
        const double rx = rays.x(u, v) * kRayOne, ry = rays.y(u, v) * kRayOne;
        for (int k = 0; k < around.count; ++k) {
          const RegionFit& fit = fits[around.label[k] - 1U];
          const double away = w - fit.surface.at(rx, ry);
          if (fit.valid && away * away <= double{most}) rest &= ~(1U << bit);
        }
      }
      if (rest != readings) measure_part(tables, depth, u0, v0, rest, map_.noise_factor, cells_[i]);
    }
  }
}

// Finds planes of at least so many cells among those that no region holds.
void RegionRefiner::discover(std::uint32_t least_cells, std::span<RegionFit> fits) noexcept {
  for (const float limit : {kFlatGroup, kSeedGroup}) discover(least_cells, limit, fits);
}

void RegionRefiner::discover(std::uint32_t least_cells, float limit,
                             std::span<RegionFit> fits) noexcept {
  for (std::uint32_t y = 1; y + 1 < map_.cells_high; ++y) {
    for (std::uint32_t x = 1; x + 1 < map_.cells_wide; ++x) {
      FloatSurface plane;
      if (map_.regions >= kMaxSurfaces) break;
      if (!seed_plane(x, y, limit, plane)) continue;
      const auto label = static_cast<std::uint8_t>(map_.regions + 1);
      const std::uint32_t seed = y * map_.cells_wide + x;
      const std::uint32_t grown = grow(seed, plane, label);
      if (grown >= least_cells) {
        map_.regions = label;
        fits[label - 1U] = {};
        fits[label - 1U].surface = plane;
        fits[label - 1U].valid = true;
        continue;
      }
      for (std::uint32_t i = 0; i < grown; ++i) labels_[queue_[i]] = 0;
      labels_[seed] = kGivenUp;
    }
  }
  std::replace(map_.labels.begin(), map_.labels.end(), kGivenUp, std::uint8_t{0});
}

RegionRefiner::Planes RegionRefiner::sum_planes(std::span<const RegionFit> fits) const noexcept {
  Planes planes{};
  for (std::size_t i = 0; i < map_.labels.size(); ++i) {
    const unsigned label = labels_[i];
    if (label == 0 || is_curved(map_, label) || !fits[label - 1].valid) continue;
    if (cell_residual(cells_[i], fits[label - 1].surface) > kCleanResidual) continue;
    planes[label].sums.add(plane_sums(cells_[i]));
    planes[label].readings += double{cells_[i].n};
  }
  FloatSurface plane;
  for (JoinPlane& p : planes) {
    if (p.sums.solve(plane)) {
      p.squares = p.sums.mean_square(plane) * p.sums.n;
    } else {
      p.readings = 0;
    }
  }
  return planes;
}

// Joins planes that are one, wherever they lie: parts of a wall behind something, shelves' fronts.
void RegionRefiner::join(std::span<RegionFit> fits) noexcept {
  Planes planes = sum_planes(fits);
  std::array<std::uint8_t, kMaxSurfaces + 1> into{};
  for (std::size_t k = 0; k < into.size(); ++k) into[k] = static_cast<std::uint8_t>(k);
  for (int a = 1; a <= map_.regions; ++a) {
    for (int b = 1; b <= map_.regions; ++b) {
      JoinPlane &first = planes[a], &second = planes[b];
      if (a == b || second.readings == 0 || first.readings < second.readings) continue;
      PlaneSums both = first.sums;
      both.add(second.sums);
      FloatSurface plane;
      if (!both.solve(plane)) continue;
      const double squares = both.mean_square(plane) * both.n;
      if (squares - first.squares - second.squares > kJoinConstant + kJoinShare * second.readings)
        continue;
      fits[a - 1].surface = plane;
      first = {both, first.readings + second.readings, squares};
      second.readings = 0;
      std::replace(into.begin(), into.end(), static_cast<std::uint8_t>(b),
                   static_cast<std::uint8_t>(a));
    }
  }
  for (std::uint8_t& label : map_.labels) label = into[label];
}

void RegionRefiner::join_same(std::span<RegionFit> fits) noexcept {
  const Planes planes = sum_planes(fits);
  std::array<std::uint8_t, kMaxSurfaces + 1> into{};
  for (std::size_t k = 0; k < into.size(); ++k) into[k] = static_cast<std::uint8_t>(k);
  const auto squares = [](const JoinPlane& plane, const FloatSurface& surface) {
    return plane.sums.mean_square(surface) * plane.sums.n;
  };
  for (int b = 1; b <= map_.regions; ++b) {
    const JoinPlane& small = planes[b];
    if (small.readings == 0) continue;
    const double own = squares(small, fits[b - 1].surface);
    double least = kJoinConstant + kJoinShare * small.readings;
    for (int a = 1; a <= map_.regions; ++a) {
      const bool larger =
          planes[a].readings > small.readings || (planes[a].readings == small.readings && a < b);
      if (!larger) continue;
      const double more = squares(small, fits[a - 1].surface) - own;
      if (more >= least) continue;
      least = more;
      into[b] = static_cast<std::uint8_t>(a);
    }
    if (into[b] != b) fits[b - 1].valid = false;
  }
  for (std::uint8_t& label : map_.labels) {
    while (into[label] != label) label = into[label];
  }
}

}  // namespace planecast
