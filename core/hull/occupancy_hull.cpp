#include "core/hull/occupancy_hull.hpp"

#include <algorithm>
#include <cmath>

namespace planecast {
namespace {

constexpr std::uint32_t kCellsPerPoint = 4;
constexpr std::uint32_t kLeastCells = 64;
constexpr int kCloseFrom = 5;  // of the eight cells round an empty one

/// Coordinates of a plane's points in steps.
struct Steps {
  const float* column[3];
  double scale;  ///< steps in a metre
  std::int64_t at(int axis, std::uint32_t place) const noexcept {
    return static_cast<std::int64_t>(std::floor(column[axis][place] * scale));
  }
};

struct Range {
  std::int64_t low, high;  ///< both inside
};

/// The coordinate of least variance, unless the plane stands too steep over the other two (a thin
/// strip that crosses them): then that along which its normal is longest.
std::uint8_t dropped_axis(const PointPlane& plane, const double variance[3]) noexcept {
  const double normal[3] = {std::abs(plane.a), std::abs(plane.b), std::abs(plane.c)};
  const auto least = static_cast<int>(std::min_element(variance, variance + 3) - variance);
  if (normal[least] >= 0.5) return static_cast<std::uint8_t>(least);
  return static_cast<std::uint8_t>(std::max_element(normal, normal + 3) - normal);
}

void measure(std::span<const std::uint32_t> members, const Steps& steps, Range range[3],
             double variance[3]) noexcept {
  for (int a = 0; a < 3; ++a) {
    const double origin = steps.column[a][members[0]];
    const auto [low, high] = std::minmax_element(
        members.begin(), members.end(),
        [&](std::uint32_t p, std::uint32_t q) { return steps.column[a][p] < steps.column[a][q]; });
    range[a] = {steps.at(a, *low), steps.at(a, *high)};
    double sum = 0, squares = 0;
    for (const std::uint32_t m : members) {
      const double d = steps.column[a][m] - origin;
      sum += d;
      squares += d * d;
    }
    const auto n = static_cast<double>(members.size());
    variance[a] = squares / n - (sum / n) * (sum / n);
  }
}

/// Grid of the draft at its pitch.
void place_grid(const Range& u, const Range& v, PatchDraft& draft) noexcept {
  const unsigned p = draft.pitch_log2;
  draft.cell_u = static_cast<std::int32_t>(u.low >> p);
  draft.cell_v = static_cast<std::int32_t>(v.low >> p);
  draft.wide = static_cast<std::uint32_t>((u.high >> p) - (u.low >> p)) + 1;
  draft.high = static_cast<std::uint32_t>((v.high >> p) - (v.low >> p)) + 1;
}

/// One round of closing: empty cells with most of their neighbours inside become inside.
void close_cells(const PatchDraft& draft, std::span<DraftCell> cells) noexcept {
  const auto inside = [&](std::int64_t i, std::int64_t j) {
    return i >= 0 && j >= 0 && i < draft.wide && j < draft.high &&
           cells[static_cast<std::size_t>(j) * draft.wide + static_cast<std::size_t>(i)].inside();
  };
  const auto around = [&](std::int64_t i, std::int64_t j) {
    int n = 0;
    for (int dj = -1; dj <= 1; ++dj) {
      for (int di = -1; di <= 1; ++di) n += (di != 0 || dj != 0) && inside(i + di, j + dj) ? 1 : 0;
    }
    return n;
  };
  // Taken in after the round: a mark that is no count waits in the cell till then.
  constexpr std::uint32_t kMark = 1U << 31U;
  for (std::uint32_t j = 0; j < draft.high; ++j) {
    for (std::uint32_t i = 0; i < draft.wide; ++i) {
      DraftCell& cell = cells[std::size_t{j} * draft.wide + i];
      if (!cell.inside() && around(i, j) >= kCloseFrom) cell.count_and_inside = kMark;
    }
  }
  for (DraftCell& cell : cells) {
    if (cell.count_and_inside == kMark) cell.count_and_inside = 1;
  }
}

}  // namespace

std::size_t hull_cells(std::uint32_t points, std::uint32_t planes) noexcept {
  return std::size_t{kCellsPerPoint} * points + std::size_t{kLeastCells} * planes;
}

Status make_hull(const PointPlane& plane, std::span<const std::uint32_t> members,
                 const PointColumns& points, double unit_m, const HullOptions& options,
                 std::span<DraftCell> cells, std::size_t& used, PatchDraft& draft) noexcept {
  if (members.empty()) return Status::kFieldRange;
  const Steps steps{{points.x.data(), points.y.data(), points.z.data()}, 1.0 / unit_m};
  const double limit = kMaxPatchCoordinate * unit_m * 0.99;
  for (const std::uint32_t m : members) {
    const bool in_range = std::abs(points.x[m]) < limit && std::abs(points.y[m]) < limit &&
                          std::abs(points.z[m]) < limit;
    if (!in_range) return Status::kFieldRange;
  }
  Range range[3];
  double variance[3];
  measure(members, steps, range, variance);
  draft = {};
  draft.axis = dropped_axis(plane, variance);
  draft.points = static_cast<std::uint32_t>(members.size());
  draft.first_cell = static_cast<std::uint32_t>(used);
  const int u = draft.axis == 0 ? 1 : 0, v = draft.axis == 2 ? 1 : 2;
  const double normal[3] = {plane.a, plane.b, plane.c};
  draft.coefficients[0] = -plane.d / normal[draft.axis] / unit_m;
  draft.coefficients[1] = -normal[u] / normal[draft.axis];
  draft.coefficients[2] = -normal[v] / normal[draft.axis];

  const std::size_t most = std::size_t{kCellsPerPoint} * members.size() + kLeastCells;
  std::span<DraftCell> grid;
  for (;; ++draft.pitch_log2) {
    place_grid(range[u], range[v], draft);
    const std::size_t count = std::size_t{draft.wide} * draft.high;
    const bool last = draft.pitch_log2 == kMaxPitchLog2;
    if (count > most && !last) continue;
    if (count > cells.size() - used) return Status::kTooLarge;
    grid = cells.subspan(used, count);
    std::fill(grid.begin(), grid.end(), DraftCell{});
    std::uint32_t occupied = 0;
    for (const std::uint32_t m : members) {
      const std::int64_t i = (steps.at(u, m) >> draft.pitch_log2) - draft.cell_u;
      const std::int64_t j = (steps.at(v, m) >> draft.pitch_log2) - draft.cell_v;
      DraftCell& cell =
          grid[static_cast<std::size_t>(j) * draft.wide + static_cast<std::size_t>(i)];
      occupied += cell.inside() ? 0 : 1;
      cell.count_and_inside = (cell.count_and_inside | 1U) + 2;
    }
    const auto n = static_cast<double>(members.size());
    if (last || occupied * options.points_per_cell <= n || occupied <= 4) break;
  }
  for (std::uint32_t round = 0; round < options.closing_rounds; ++round) close_cells(draft, grid);
  used += grid.size();
  return Status::kOk;
}

}  // namespace planecast
