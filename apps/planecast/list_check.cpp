#include "apps/planecast/list_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <vector>

#include "core/model/point_grid.hpp"
#include "core/search/kdtree_search.hpp"

namespace planecast {
namespace {

using Bits = std::array<std::int32_t, 3>;

std::vector<Bits> sorted_bits(std::span<const Point3f> points) {
  std::vector<Bits> out;
  for (const Point3f& p : points)
    out.push_back({rank_of_float(p.x), rank_of_float(p.y), rank_of_float(p.z)});
  std::sort(out.begin(), out.end());
  return out;
}

// Largest distance of a point of `from` to its nearest in `to` [m]; infinite when `to` is empty.
double farthest(std::span<const Point3f> from, std::span<const Point3f> to) {
  const KdTreeSearch tree(to);
  double worst = 0;
  for (const Point3f& p : from) worst = std::max(worst, tree.nearest(p).sq_dist);
  return std::sqrt(worst);
}

struct Parts {
  std::vector<Point3f> coded, kept;  // as themselves; these and those on surfaces
};

Parts parts_of(const CodedList& list) {
  Parts out;
  for (std::size_t i = 0; i < list.points.size(); ++i) {
    const PointFate fate = list.fates[i];
    if (fate == PointFate::kCoded) out.coded.push_back(list.points[i]);
    if (fate == PointFate::kCoded || fate == PointFate::kOnSurface)
      out.kept.push_back(list.points[i]);
  }
  return out;
}

}  // namespace

OriginalFrame original_list(const CodedList& list) {
  return {list.points, {}, static_cast<std::uint32_t>(list.points.size())};
}

FrameVerdict check_list(const StreamSetup& setup, const CodedList& list,
                        std::span<const Point3f> decoded) {
  FrameVerdict verdict;
  const Parts parts = parts_of(list);
  verdict.points_out = static_cast<std::uint32_t>(decoded.size());
  const auto out = static_cast<std::int64_t>(decoded.size());
  const std::int64_t missing = static_cast<std::int64_t>(parts.kept.size()) - out;
  verdict.lost = static_cast<std::uint32_t>(
      std::max<std::int64_t>(0, static_cast<std::int64_t>(list.points.size()) - out));
  verdict.invented = static_cast<std::uint32_t>(std::max<std::int64_t>(0, -missing));
  const ToleranceKind kind = setup.encoder.stream.tolerance;
  const bool same =
      kind == ToleranceKind::kLossless && sorted_bits(parts.kept) == sorted_bits(decoded);
  verdict.identical = same && parts.kept.size() == list.points.size();
  if (missing != 0) {
    verdict.broken = fmt::format("{} points were to come back, but {} did", parts.kept.size(), out);
    return verdict;
  }
  if (kind == ToleranceKind::kLossless) {
    if (!same) verdict.broken = "the points that came back are not those that were coded";
    return verdict;
  }
  const double there = farthest(parts.coded, decoded);
  // Points of surfaces lie where the surfaces say, not where a point was.
  const double back = kind == ToleranceKind::kSurfaces ? 0 : farthest(decoded, parts.coded);
  verdict.max_m = std::max(there, back);
  const double bound_m = setup.contract.bound_m(0);
  verdict.utilisation = bound_m > 0 ? verdict.max_m / bound_m : 0;
  if (verdict.max_m > bound_m) {
    verdict.broken = fmt::format(
        "a point is {:.6g} mm from the nearest that {}, over the bound of "
        "{:.6g} mm",
        verdict.max_m * 1e3, there > back ? "came back" : "went in", bound_m * 1e3);
  }
  return verdict;
}

}  // namespace planecast
