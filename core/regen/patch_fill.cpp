#include "core/regen/patch_fill.hpp"

#include <algorithm>

namespace planecast {
namespace {

std::uint64_t square_root(std::uint64_t value) noexcept {  // rounded down, bit by bit
  std::uint64_t root = 0;
  for (std::uint64_t bit = std::uint64_t{1} << 31U; bit != 0; bit >>= 1U) {
    const std::uint64_t next = root | bit;
    if (next * next <= value) root = next;
  }
  return root;
}

/// How rows of points lie on rows of cells: `sub_rows` in each, or one in a band of `band` of them.
struct RowPlan {
  std::uint32_t sub_rows = 1;
  std::uint32_t band = 1;
};

/// Rows about as far apart as the points in a row: the spacing is the square root of a point's
/// share of the area.
RowPlan plan_rows(std::uint32_t inside, std::uint32_t points, unsigned pitch_log2) noexcept {
  // In 1/256 cell, so that neither small cells nor few points lose the spacing to rounding.
  const std::uint64_t spacing =
      std::max<std::uint64_t>(1, square_root((std::uint64_t{inside} << 32U) / points) >> 8U);
  RowPlan plan;
  if (spacing < 256) {
    plan.sub_rows = static_cast<std::uint32_t>((256 + spacing / 2) / spacing);
    plan.sub_rows = std::min(plan.sub_rows, 1U << pitch_log2);
  } else {
    plan.band = static_cast<std::uint32_t>((spacing + 128) / 256);
  }
  return plan;
}

}  // namespace

void PatchFiller::layout(Arena& arena) noexcept {
  inside_ = arena.take<std::uint32_t>(kMaxPatchCells);
}

Status PatchFiller::fill(const Patch& patch, std::span<const std::uint8_t> cells,
                         const PointStream& stream, Pcg32& generator,
                         std::span<Point3f> out) noexcept {
  if (const Status status = check_patch(patch); status != Status::kOk) return status;
  if (cells.size() != std::size_t{patch.wide} * patch.high || out.size() != patch.points ||
      inside_.size() < cells.size()) {
    return Status::kWrongSize;
  }
  std::uint32_t inside = 0;
  for (std::uint32_t i = 0; i < cells.size(); ++i) {
    if (cells[i] != 0) inside_[inside++] = i;
  }
  if (inside == 0) return Status::kFieldRange;
  const double unit_m = patch_unit_m(stream);
  if (stream.fill == FillMode::kRandom)
    fill_random(patch, inside, unit_m, generator, out);
  else
    fill_lattice(patch, cells, inside, unit_m, out);
  return Status::kOk;
}

void PatchFiller::fill_random(const Patch& patch, std::uint32_t inside, double unit_m,
                              Pcg32& generator, std::span<Point3f> out) noexcept {
  const PatchSurface surface(patch);
  const unsigned p = patch.pitch_log2;
  const auto within = [&]() { return p == 0 ? 0 : generator.next() >> (32U - p); };
  for (Point3f& point : out) {
    const std::uint32_t cell = inside_[generator.below(inside)];
    const std::int64_t i = std::int64_t{patch.cell_u} + cell % patch.wide;
    const std::int64_t j = std::int64_t{patch.cell_v} + cell / patch.wide;
    const std::int64_t u = i * (std::int64_t{1} << p) + within();
    const std::int64_t v = j * (std::int64_t{1} << p) + within();
    point = patch_point(patch.axis, u, v, surface.height(u, v), unit_m);
  }
}

// One walk over all rows, as if they were one line: a point stands in the middle of every n-th part
// of its length. A column of a band is as long as it has cells, and its points stand in the middle
// one of these: so areas that a band cuts still get their share.
void PatchFiller::fill_lattice(const Patch& patch, std::span<const std::uint8_t> cells,
                               std::uint32_t inside, double unit_m,
                               std::span<Point3f> out) noexcept {
  const PatchSurface surface(patch);
  const unsigned p = patch.pitch_log2;
  const RowPlan plan = plan_rows(inside, patch.points, p);
  const std::int64_t side = std::int64_t{1} << p;
  const std::uint64_t length = std::uint64_t{inside} * plan.sub_rows;  // [cells]
  const std::uint64_t points = out.size();
  std::uint64_t walked = 0;  // [cells]
  std::size_t next = 0;      // stands at (2 next + 1) length / (2 points)
  for (std::uint32_t j = 0; j < patch.high; j += plan.band) {
    const std::uint32_t rows = std::min(plan.band, patch.high - j);
    for (std::uint32_t r = 0; r < plan.sub_rows; ++r) {
      for (std::uint32_t i = 0; i < patch.wide; ++i) {
        std::uint32_t here = 0;
        for (std::uint32_t b = 0; b < rows; ++b) here += cells[(j + b) * patch.wide + i] != 0;
        if (here == 0) continue;
        std::uint32_t nth = here / 2, row = 0;
        for (;; ++row) {
          if (cells[(j + row) * patch.wide + i] != 0 && nth-- == 0) break;
        }
        // In units of 1 / (2 points) cell.
        const std::uint64_t end = (walked + here) * 2 * points;
        for (; next < points && (2 * next + 1) * length < end; ++next) {
          const std::uint64_t into = (2 * next + 1) * length - walked * 2 * points;
          const auto du = static_cast<std::int64_t>((into << p) / (here * 2 * points));
          const std::int64_t dv = plan.sub_rows > 1
                                      ? ((2 * std::int64_t{r} + 1) * side) / (2 * plan.sub_rows)
                                      : side / 2;
          const std::int64_t u = (std::int64_t{patch.cell_u} + i) * side + du;
          const std::int64_t v = (std::int64_t{patch.cell_v} + j + row) * side + dv;
          out[next] = patch_point(patch.axis, u, v, surface.height(u, v), unit_m);
        }
        walked += here;
      }
    }
  }
}

}  // namespace planecast
