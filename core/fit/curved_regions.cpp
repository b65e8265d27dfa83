#include "core/fit/curved_regions.hpp"

#include <algorithm>
#include <cmath>

namespace planecast {
namespace {

// What one plane and two may add to the squared residuals of a surface of degree two: a constant,
// since neighbouring pixels share noise, and a share of the readings.
constexpr double kOneConstant = 400, kOneShare = 0.05, kTwoConstant = 400;
constexpr std::uint32_t kLeastCells = 6;  // of either of two planes
constexpr int kRounds = 4;

struct TwoPlanes {
  FloatSurface plane[2];
  double squares = 0;
};

double squares_of(const Cell& cell, float residual) noexcept {
  return double{cell.n} * double{std::min(residual, kMostCellResidual)};
}

bool is_second(const Cell& cell, const TwoPlanes& two) noexcept {
  return cell_residual(cell, two.plane[1]) < cell_residual(cell, two.plane[0]);
}

// The direction across which a surface bends most.
void bend_direction(const FloatSurface& s, double& x, double& y) noexcept {
  const double half = 0.5 * (s.d - s.f), mixed = 0.5 * s.e, middle = 0.5 * (s.d + s.f);
  const double size = std::sqrt(half * half + mixed * mixed);
  const double most = middle >= 0 ? middle + size : middle - size;
  // (form - most) v = 0, by the row that says more.
  if (std::abs(s.d - most) > std::abs(s.f - most)) {
    x = -mixed;
    y = s.d - most;
  } else {
    x = s.f - most;
    y = -mixed;
  }
}

// Lets cells and two planes settle on each other; `second` tells the first guess.
template <class Second>
bool settle(std::span<const Cell> cells, std::span<const std::uint32_t> of, Second&& second,
            TwoPlanes& two) noexcept {
  PlaneSums sums[2];
  for (const std::uint32_t i : of) sums[second(cells[i]) ? 1 : 0].add(plane_sums(cells[i]));
  for (int round = 0; round < kRounds; ++round) {
    if (!sums[0].solve(two.plane[0]) || !sums[1].solve(two.plane[1])) return false;
    std::uint32_t count[2] = {};
    sums[0] = sums[1] = {};
    two.squares = 0;
    for (const std::uint32_t i : of) {
      const float first = cell_residual(cells[i], two.plane[0]);
      const float other = cell_residual(cells[i], two.plane[1]);
      const float least = std::min(first, other);
      two.squares += squares_of(cells[i], least);
      if (least > kMostCellResidual) continue;
      sums[other < first ? 1 : 0].add(plane_sums(cells[i]));
      ++count[other < first ? 1 : 0];
    }
    if (std::min(count[0], count[1]) < kLeastCells) return false;
  }
  return true;
}

// The best two planes from first guesses parted across the bend; false when there are none.
bool best_two(std::span<const Cell> cells, std::span<const std::uint32_t> of,
              const FloatSurface& curved, TwoPlanes& best) noexcept {
  double x = 0, y = 0, sum = 0, square = 0;
  bend_direction(curved, x, y);
  const auto along = [&](const Cell& cell) { return x * double{cell.x} + y * double{cell.y}; };
  for (const std::uint32_t i : of) {
    const double at = along(cells[i]);
    sum += at;
    square += at * at;
  }
  const auto count = static_cast<double>(of.size());
  const double mean = sum / count, spread = std::sqrt(std::max(0.0, square / count - mean * mean));
  bool found = false;
  for (const double off : {-0.7, 0.0, 0.7}) {
    TwoPlanes two;
    const auto second = [&](const Cell& cell) { return along(cell) > mean + off * spread; };
    if (!settle(cells, of, second, two) || (found && two.squares >= best.squares)) continue;
    best = two;
    found = true;
  }
  return found;
}

// A region's cells, first in `scratch`, with how well its surface and how well one plane fit them.
struct Weighed {
  std::span<const std::uint32_t> cells;
  FloatSurface plane;
  double curved = 0, flat = 0, readings = 0;  ///< squared residuals of both; what they are of
  bool valid = false;                         ///< the cells have a plane
};

Weighed weigh(const RegionMap& regions, int label, const FloatSurface& surface,
              std::span<std::uint32_t> scratch) noexcept {
  Weighed out;
  PlaneSums sums;
  std::size_t count = 0;
  for (std::uint32_t i = 0; i < regions.labels.size(); ++i) {
    if (regions.labels[i] != label) continue;
    scratch[count++] = i;
    const Cell& cell = regions.cells[i];
    const float residual = cell_residual(cell, surface);
    out.curved += squares_of(cell, residual);
    out.readings += double{cell.n};
    if (residual <= kMostCellResidual) sums.add(plane_sums(cell));
  }
  out.cells = scratch.first(count);
  out.valid = sums.solve(out.plane);
  if (!out.valid) return out;
  for (const std::uint32_t i : out.cells)
    out.flat += squares_of(regions.cells[i], cell_residual(regions.cells[i], out.plane));
  return out;
}

}  // namespace

int flatten_curved(RegionMap& regions, std::span<RegionFit> fits,
                   std::span<std::uint32_t> scratch) noexcept {
  int changed = 0;
  const int before = regions.regions;
  for (int k = 1; k <= before; ++k) {
    RegionFit& fit = fits[k - 1];
    const std::uint64_t bit = std::uint64_t{1} << k;
    if ((regions.curved & bit) == 0 || !fit.valid) continue;
    const Weighed region = weigh(regions, k, fit.surface, scratch);
    if (!region.valid) continue;
    TwoPlanes two;
    if (region.flat - region.curved <= kOneConstant + kOneShare * region.readings) {
      fit.surface = region.plane;
    } else if (regions.regions < kMaxSurfaces &&
               best_two(regions.cells, region.cells, fit.surface, two) &&
               two.squares - region.curved <= kTwoConstant) {
      const int label = ++regions.regions;
      for (const std::uint32_t i : region.cells) {
        if (is_second(regions.cells[i], two)) regions.labels[i] = static_cast<std::uint8_t>(label);
      }
      fit.surface = two.plane[0];
      fits[label - 1] = fit;
      fits[label - 1].surface = two.plane[1];
    } else {
      continue;
    }
    regions.curved &= ~bit;
    ++changed;
  }
  return changed;
}

}  // namespace planecast
