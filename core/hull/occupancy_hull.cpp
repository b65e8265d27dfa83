#include "core/hull/occupancy_hull.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace planecast {
namespace {

constexpr std::uint32_t kCellsPerPoint = 4;
constexpr std::uint32_t kLeastCells = 32;
constexpr int kCloseFrom = 5;  // of the eight cells round an empty one
constexpr std::size_t kMostWaiting = 128;

struct Range {
  std::int64_t low, high;  ///< both inside
};

/// The coordinate of least variance, unless the plane stands too steep over the other two (a thin
/// strip that crosses them): then that along which its normal is longest.
std::uint8_t dropped_axis(const PointPlane& plane, const std::array<double, 3>& variance) noexcept {
  const std::array<double, 3> normal = {std::abs(plane.a), std::abs(plane.b), std::abs(plane.c)};
  const auto least = std::min_element(variance.begin(), variance.end()) - variance.begin();
  if (normal[static_cast<std::size_t>(least)] >= 0.5) return static_cast<std::uint8_t>(least);
  return static_cast<std::uint8_t>(std::max_element(normal.begin(), normal.end()) - normal.begin());
}

double variance_of(std::span<const float> column, std::span<const std::uint32_t> members) noexcept {
  const double origin = column[members[0]];
  double sum = 0, squares = 0;
  for (const std::uint32_t m : members) {
    const double d = column[m] - origin;
    sum += d;
    squares += d * d;
  }
  const auto n = static_cast<double>(members.size());
  return squares / n - (sum / n) * (sum / n);
}

/// A plane's members on its grid: what every part of it shares.
class PlaneGrid {
 public:
  PlaneGrid(const PointPlane& plane, std::span<const std::uint32_t> members,
            const PointColumns& points, double unit_m) noexcept
      : scale_(1 / unit_m) {
    const std::array<std::span<const float>, 3> columns = {points.x, points.y, points.z};
    std::array<double, 3> variance{};
    for (std::size_t a = 0; a < 3; ++a) variance[a] = variance_of(columns[a], members);
    model_.axis = dropped_axis(plane, variance);
    const std::size_t u = model_.axis == 0 ? 1 : 0, v = model_.axis == 2 ? 1 : 2;
    u_ = columns[u].data();
    v_ = columns[v].data();
    const std::array<double, 3> normal = {plane.a, plane.b, plane.c};
    model_.coefficients[0] = -plane.d / normal[model_.axis] / unit_m;
    model_.coefficients[1] = -normal[u] / normal[model_.axis];
    model_.coefficients[2] = -normal[v] / normal[model_.axis];
  }

  const PatchDraft& model() const noexcept { return model_; }
  std::int64_t u(std::uint32_t m) const noexcept { return steps(u_[m]); }
  std::int64_t v(std::uint32_t m) const noexcept { return steps(v_[m]); }

  Range range(bool along_u, std::span<const std::uint32_t> members) const noexcept {
    const float* column = along_u ? u_ : v_;
    float low = column[members[0]], high = low;
    for (const std::uint32_t m : members) {
      low = std::min(low, column[m]);
      high = std::max(high, column[m]);
    }
    return {steps(low), steps(high)};
  }

  /// Cell of a member in a draft's grid.
  std::size_t cell(const PatchDraft& d, std::uint32_t m) const noexcept {
    const std::int64_t i = (u(m) >> d.pitch_log2) - d.cell_u;
    const std::int64_t j = (v(m) >> d.pitch_log2) - d.cell_v;
    return static_cast<std::size_t>(j) * d.wide + static_cast<std::size_t>(i);
  }

 private:
  std::int64_t steps(float metres) const noexcept {
    return static_cast<std::int64_t>(std::floor(metres * scale_));
  }

  const float *u_, *v_;
  double scale_;  ///< steps in a metre
  PatchDraft model_;
};

/// How many of the eight cells round (i, j) are inside.
int inside_around(const PatchDraft& draft, std::span<const DraftCell> cells, std::uint32_t i,
                  std::uint32_t j) noexcept {
  int n = 0;
  const std::uint32_t i0 = i > 0 ? i - 1 : 0, i1 = std::min(i + 2, draft.wide);
  const std::uint32_t j0 = j > 0 ? j - 1 : 0, j1 = std::min(j + 2, draft.high);
  for (std::uint32_t b = j0; b < j1; ++b) {
    for (std::uint32_t a = i0; a < i1; ++a)
      n += (a != i || b != j) && cells[std::size_t{b} * draft.wide + a].inside() ? 1 : 0;
  }
  return n;
}

/// Calls `change` on the cells that `wanted` accepts, all judged before any is changed: a mark that
/// no count can be waits in the cell till then.
template <class Wanted, class Change>
void change_cells(const PatchDraft& draft, std::span<DraftCell> cells, Wanted wanted,
                  Change change) noexcept {
  constexpr std::uint32_t kMark = 1U << 31U;
  for (std::uint32_t j = 0; j < draft.high; ++j) {
    for (std::uint32_t i = 0; i < draft.wide; ++i) {
      DraftCell& cell = cells[std::size_t{j} * draft.wide + i];
      if (wanted(cell, i, j)) cell.count_and_inside |= kMark;
    }
  }
  for (DraftCell& cell : cells) {
    if ((cell.count_and_inside & kMark) == 0) continue;
    cell.count_and_inside &= ~kMark;
    change(cell);
  }
}

/// Empty cells with most of their neighbours inside become inside.
void close_cells(const PatchDraft& draft, std::span<DraftCell> cells) noexcept {
  change_cells(
      draft, cells,
      [&](const DraftCell& cell, std::uint32_t i, std::uint32_t j) {
        return !cell.inside() && inside_around(draft, cells, i, j) >= kCloseFrom;
      },
      [](DraftCell& cell) { cell.count_and_inside = 1; });
}

/// Cells that touch no other are given up, unless they hold a patch's worth of points alone.
void drop_lonely(PatchDraft& draft, std::span<DraftCell> cells, std::uint32_t least) noexcept {
  change_cells(
      draft, cells,
      [&](const DraftCell& cell, std::uint32_t i, std::uint32_t j) {
        return cell.inside() && cell.count() < least && inside_around(draft, cells, i, j) == 0;
      },
      [&](DraftCell& cell) {
        draft.points -= cell.count();
        cell.count_and_inside = 0;
      });
}

class HullMaker {
 public:
  HullMaker(const PlaneGrid& grid, const HullOptions& options, std::uint32_t least,
            HullOutput& output) noexcept
      : grid_(grid), options_(options), least_(least), output_(output) {}

  /// A draft of the part, or the part in two (`cut` of them in the first); neither (kept 0, cut 0)
  /// when it has too few points. Members that the draft leaves out come last.
  Status make(std::span<std::uint32_t> part, std::size_t& cut, std::size_t& kept) noexcept {
    cut = kept = 0;
    if (part.size() < least_) return Status::kOk;
    PatchDraft draft = grid_.model();
    const Range u = grid_.range(true, part), v = grid_.range(false, part);
    std::span<DraftCell> cells;
    std::uint32_t occupied = 0;
    if (const Status status = occupy(part, u, v, draft, cells, occupied); status != Status::kOk)
      return status;
    // Cells that are wide only because the rectangle is, and hold many points each: a strip across
    // it, or islands far apart. In halves of the rectangle they can be finer.
    const bool crowded =
        occupied * 1.4 * options_.points_per_cell <= static_cast<double>(part.size());
    if (draft.pitch_log2 > kAlphaPitchLog2 && crowded) {
      const bool along_u = draft.wide >= draft.high;
      const Range& r = along_u ? u : v;
      const std::int64_t line = (((r.low + r.high) / 2) >> kAlphaPitchLog2) << kAlphaPitchLog2;
      const auto middle = std::partition(part.begin(), part.end(), [&](std::uint32_t m) {
        return (along_u ? grid_.u(m) : grid_.v(m)) < line;
      });
      cut = static_cast<std::size_t>(middle - part.begin());
      if (cut > 0 && cut < part.size()) return Status::kOk;
      cut = 0;
    }
    const auto n = static_cast<double>(part.size());
    while (occupied * options_.points_per_cell > n && occupied > 4 &&
           draft.pitch_log2 < kMaxPitchLog2) {
      ++draft.pitch_log2;
      if (const Status status = occupy(part, u, v, draft, cells, occupied); status != Status::kOk)
        return status;
    }
    return finish(part, draft, cells, kept);
  }

 private:
  /// Grid of the draft at its pitch.
  static void place(const Range& u, const Range& v, PatchDraft& draft) noexcept {
    const unsigned p = draft.pitch_log2;
    draft.cell_u = static_cast<std::int32_t>(u.low >> p);
    draft.cell_v = static_cast<std::int32_t>(v.low >> p);
    draft.wide = static_cast<std::uint32_t>((u.high >> p) - (u.low >> p)) + 1;
    draft.high = static_cast<std::uint32_t>((v.high >> p) - (v.low >> p)) + 1;
  }

  /// Counts the part's points in cells of the draft's pitch, or of the finest above it that makes
  /// few enough cells.
  Status occupy(std::span<const std::uint32_t> part, const Range& u, const Range& v,
                PatchDraft& draft, std::span<DraftCell>& cells, std::uint32_t& occupied) noexcept {
    const std::size_t most = std::size_t{kCellsPerPoint} * part.size() + kLeastCells;
    for (;; ++draft.pitch_log2) {
      place(u, v, draft);
      if (std::size_t{draft.wide} * draft.high <= most || draft.pitch_log2 == kMaxPitchLog2) break;
    }
    const std::size_t count = std::size_t{draft.wide} * draft.high;
    occupied = 0;
    if (count > most) return Status::kOk;  // too wide for any pitch: none occupied, to be cut
    if (count > output_.cells.size() - output_.cells_used) return Status::kTooLarge;
    cells = output_.cells.subspan(output_.cells_used, count);
    std::fill(cells.begin(), cells.end(), DraftCell{});
    for (const std::uint32_t m : part) {
      DraftCell& cell = cells[grid_.cell(draft, m)];
      occupied += cell.inside() ? 0 : 1;
      cell.count_and_inside = (cell.count_and_inside | 1U) + 2;
    }
    return Status::kOk;
  }

  Status finish(std::span<std::uint32_t> part, PatchDraft& draft, std::span<DraftCell> cells,
                std::size_t& kept) noexcept {
    draft.points = static_cast<std::uint32_t>(part.size());
    draft.first_cell = static_cast<std::uint32_t>(output_.cells_used);
    drop_lonely(draft, cells, least_);
    if (draft.points == 0) return Status::kOk;
    for (std::uint32_t round = 0; round < options_.closing_rounds; ++round)
      close_cells(draft, cells);
    if (output_.drafts_used == output_.drafts.size()) return Status::kTooLarge;
    output_.drafts[output_.drafts_used++] = draft;
    output_.cells_used += cells.size();
    const auto end = std::partition(part.begin(), part.end(), [&](std::uint32_t m) {
      return cells[grid_.cell(draft, m)].inside();
    });
    kept = static_cast<std::size_t>(end - part.begin());
    return Status::kOk;
  }

  const PlaneGrid& grid_;
  const HullOptions& options_;
  std::uint32_t least_;
  HullOutput& output_;
};

}  // namespace

std::size_t hull_cells(std::uint32_t points, std::uint32_t planes,
                       const HullOptions& options) noexcept {
  return std::size_t{kCellsPerPoint} * points +
         std::size_t{kLeastCells} * hull_drafts(points, planes, options);
}

std::size_t hull_drafts(std::uint32_t points, std::uint32_t planes,
                        const HullOptions& options) noexcept {
  return std::size_t{points} / std::max(2U, options.least_points) + planes;
}

Status make_hulls(const PointPlane& plane, std::span<std::uint32_t> members,
                  const PointColumns& points, double unit_m, const HullOptions& options,
                  HullOutput& output, std::uint32_t& kept) noexcept {
  kept = 0;
  const bool sound = options.least_points >= 2 && options.points_per_cell >= 0 && unit_m > 0;
  if (!sound) return Status::kBadConfig;
  if (members.empty()) return Status::kOk;
  // Half of the format's range: the widest cells then still end inside it.
  const double limit = kMaxPatchCoordinate / 2 * unit_m;
  for (const std::uint32_t m : members) {
    const bool in_range = std::abs(points.x[m]) < limit && std::abs(points.y[m]) < limit &&
                          std::abs(points.z[m]) < limit;
    if (!in_range) return Status::kFieldRange;
  }
  const PlaneGrid grid(plane, members, points, unit_m);
  const auto least = std::min(options.least_points, static_cast<std::uint32_t>(members.size()));
  HullMaker maker(grid, options, least, output);
  std::array<std::span<std::uint32_t>, kMostWaiting> waiting;
  std::size_t waits = 0;
  waiting[waits++] = members;
  while (waits > 0) {
    const std::span<std::uint32_t> part = waiting[--waits];
    std::size_t cut = 0, stay = 0;
    if (const Status status = maker.make(part, cut, stay); status != Status::kOk) return status;
    if (cut > 0 && waits + 2 <= waiting.size()) {
      waiting[waits++] = part.subspan(cut);
      waiting[waits++] = part.first(cut);
      continue;
    }
    // Kept members move up to those kept before; parts are worked off from the front.
    for (std::size_t n = 0; n < stay; ++n) std::swap(members[kept++], part[n]);
  }
  return Status::kOk;
}

}  // namespace planecast
