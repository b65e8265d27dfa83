#include "core/fit/surface_fitter.hpp"

#include <algorithm>

#include "core/fit/align_planes.hpp"
#include "core/fit/on_surface.hpp"
#include "core/fit/plane_fit.hpp"
#include "core/fit/surface_quantise.hpp"

namespace planecast {

void SurfaceFitter::layout(Arena& arena, std::uint32_t max_width,
                           std::uint32_t max_height) noexcept {
  labeller_.layout(arena, max_width, max_height);
  refiner_.layout(arena, max_width, max_height);
  const std::size_t blocks = std::size_t{(max_width + 7) / 8} * ((max_height + 7) / 8);
  scratch_ = arena.take<std::uint32_t>(blocks);
  off_ = arena.take<std::uint64_t>(blocks);
}

Status SurfaceFitter::fit(const FitTables& tables, std::span<const std::uint16_t> depth,
                          RegionMap& regions, std::span<BlockLabel> labels,
                          std::span<Surface> surfaces, FitReport& report,
                          const ConsensusOptions& options) noexcept {
  report = {};
  const std::size_t blocks = std::size_t{blocks_wide(tables)} * blocks_high(tables);
  if (depth.size() != std::size_t{tables.rays->width} * tables.rays->height ||
      labels.size() != blocks || regions.labels.size() != blocks ||
      surfaces.size() < static_cast<std::size_t>(kMaxSurfaces)) {
    return Status::kWrongSize;
  }
  if (blocks > scratch_.size()) return Status::kFrameTooLarge;
  fit_regions(regions, fits_);
  report.split_regions =
      static_cast<std::uint32_t>(split_regions(regions, fits_, scratch_, options));
  refit_inside(regions, fits_);
  const bool contract = tables.config->tolerance == ToleranceKind::kSurfaces;
  if (contract) {
    refined_ = refiner_.process(tables, depth, regions, fits_);
    (void)align_planes(refined_, fits_);
    refiner_.join_same(fits_);
  }
  const RegionMap& final = contract ? refined_ : regions;
  const std::span<const RegionFit> fits =
      std::span(fits_).first(static_cast<std::size_t>(final.regions));
  const int shift = choose_shift(fits, largest_ray_sum(*tables.rays, final.curved != 0));
  report.shift = static_cast<std::uint8_t>(shift);
  std::array<std::uint8_t, kMaxSurfaces + 1> surface_of{};
  for (std::size_t k = 0; k < fits.size(); ++k) {
    if (!fits[k].valid) continue;
    if (!quantise_surface(fits[k].surface, shift, surfaces[report.surfaces])) continue;
    surface_of[k + 1] = static_cast<std::uint8_t>(++report.surfaces);
  }
  const std::span<const Surface> found = surfaces.first(report.surfaces);
  if (contract) {
    label_on_surface(tables, depth, final, surface_of, found, labels, off_.first(blocks));
  } else {
    labeller_.process(tables, depth, regions, surface_of, found, labels);
  }
  keep_used(labels, surfaces, report);
  return Status::kOk;
}

void SurfaceFitter::keep_used(std::span<BlockLabel> labels, std::span<Surface> surfaces,
                              FitReport& report) noexcept {
  std::array<std::uint8_t, kMaxSurfaces + 1> number{};
  for (const BlockLabel& label : labels) {
    number[label.first] = 1;
    number[label.second] = 1;
    report.labelled_blocks += label.first != 0 ? 1U : 0U;
  }
  number[0] = 0;
  std::uint8_t kept = 0;
  for (std::uint32_t k = 1; k <= report.surfaces; ++k) {
    if (number[k] == 0) continue;
    number[k] = ++kept;
    surfaces[kept - 1U] = surfaces[k - 1];
  }
  for (BlockLabel& label : labels) label = {number[label.first], number[label.second]};
  report.surfaces = kept;
}

}  // namespace planecast
