#include "core/fit/consensus.hpp"

#include <algorithm>

#include "core/base/random.hpp"

namespace planecast {
namespace {

// Most cells that vote on a sample: more add time and no certainty.
constexpr std::size_t kVoters = 128;

// Samples of three after which one free of outliers has come with 99 %, by tenths of cells on the
// plane: log(0.01) / log(1 - share^3).
constexpr std::uint32_t kEnoughTrials[11] = {4603, 4603, 574, 169, 70, 35, 19, 11, 7, 4, 1};

std::size_t collect(const RegionMap& regions, unsigned label, std::span<std::uint32_t> out) {
  std::size_t n = 0;
  for (std::uint32_t i = 0; i < regions.cells.size(); ++i) {
    if (regions.labels[i] == label) out[n++] = i;
  }
  return n;
}

PlaneSums sums_within(const RegionMap& regions, std::span<const std::uint32_t> cells,
                      const FloatSurface& plane, float limit) {
  PlaneSums sums;
  for (const std::uint32_t i : cells) {
    const Cell& cell = regions.cells[i];
    if (cell_residual(cell, plane) <= limit) sums.add(plane_sums(cell));
  }
  return sums;
}

// The plane most cells agree on; false when too few do.
bool strongest_plane(const RegionMap& regions, std::span<const std::uint32_t> cells, Pcg32& random,
                     const ConsensusOptions& options, FloatSurface& best) {
  const auto count = static_cast<std::uint32_t>(cells.size());
  const std::size_t stride = cells.size() / kVoters + 1;
  const std::size_t voters = (cells.size() + stride - 1) / stride;
  std::uint32_t most = 0;
  std::uint32_t enough = options.trials;
  for (std::uint32_t t = 0; t < enough; ++t) {
    PlaneSums three;
    for (int i = 0; i < 3; ++i) {
      three.add(plane_sums(regions.cells[cells[random.below(count)]]));
    }
    FloatSurface plane;
    if (!three.solve(plane)) continue;
    std::uint32_t votes = 0;
    for (std::size_t i = 0; i < cells.size(); i += stride) {
      votes += cell_residual(regions.cells[cells[i]], plane) <= options.inlier_residual ? 1U : 0U;
    }
    if (votes > most) {
      most = votes;
      best = plane;
      enough = std::min(enough, kEnoughTrials[10 * votes / voters]);
    }
  }
  if (most == 0) return false;
  for (int round = 0; round < 2; ++round) {
    const PlaneSums agreed = sums_within(regions, cells, best, options.inlier_residual);
    if (!agreed.solve(best)) return false;
  }
  return true;
}

// Moves cells that are not on the plane to the front, returns how many there are.
std::size_t move_off_plane_first(const RegionMap& regions, std::span<std::uint32_t> cells,
                                 const FloatSurface& plane, float limit) {
  std::size_t off = 0;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (cell_residual(regions.cells[cells[i]], plane) > limit) std::swap(cells[off++], cells[i]);
  }
  return off;
}

}  // namespace

int split_regions(RegionMap& regions, std::span<RegionFit> fits, std::span<std::uint32_t> scratch,
                  const ConsensusOptions& options) noexcept {
  int split = 0;
  std::uint64_t changed = 0;  // labels, as bits
  const int before = regions.regions;
  for (int k = 1; k <= before; ++k) {
    const RegionFit& fit = fits[k - 1];
    if (!fit.valid || fit.residual <= options.clear_residual) continue;
    if (((regions.curved >> k) & 1U) != 0) continue;
    if (fit.cells < 2 * options.min_cells) continue;
    Pcg32 random(options.seed, static_cast<std::uint64_t>(k));
    std::size_t left = collect(regions, static_cast<unsigned>(k), scratch);
    bool first = true;
    while (left >= options.min_cells && (first || regions.regions < kMaxSurfaces)) {
      const std::span<std::uint32_t> cells = scratch.first(left);
      FloatSurface plane;
      if (!strongest_plane(regions, cells, random, options, plane)) break;
      const std::size_t off = move_off_plane_first(regions, cells, plane, options.inlier_residual);
      if (left - off < options.min_cells) break;
      const int label = first ? k : ++regions.regions;
      changed |= std::uint64_t{1} << label;
      for (const std::uint32_t i : cells.subspan(off)) {
        regions.labels[i] = static_cast<std::uint8_t>(label);
      }
      first = false;
      left = off;
    }
    if (first) continue;  // no plane stands out: curved or rough, and better left as it is
    ++split;
    for (const std::uint32_t i : scratch.first(left)) regions.labels[i] = 0;
  }
  if (split > 0) fit_regions(regions, fits, changed);
  return split;
}

}  // namespace planecast
