// Planes in the regions of an unorganised cloud by sample consensus, several a region while enough
// points remain (the paper's Algorithm 1, Eqs. 6 to 9).
#pragma once

#include <cstdint>
#include <span>

#include "core/base/arena.hpp"
#include "core/base/random.hpp"
#include "core/base/status.hpp"
#include "core/model/patch_draft.hpp"

namespace planecast {

struct PointPlaneOptions {
  double distance_m = 0.01;       ///< of a point from its plane, at most; > 0
  std::uint32_t iterations = 50;  ///< samples tried for a plane, at most
  double confidence = 0.99;       ///< stop when a better sample is this unlikely, 0..1
  std::uint32_t min_points = 50;  ///< of a plane; at least 3
  double min_share = 0.1;         ///< of the region's points that must remain for another plane
  std::uint64_t seed = 1;
};

/// Fits planes. One thread; memory (36 bytes a point) from the arena at start.
class PointPlaneFitter {
 public:
  void layout(Arena& arena, std::uint32_t max_points) noexcept;

  /// Finds planes in the regions of `points`: regions[i] < region_count, or anything else for a
  /// point in none. `planes` receives them, region by region, the plane of most points first, and
  /// `members` their points, plane by plane (PointPlane::first and count); a point is in one plane
  /// at most, and within distance_m of it. kWrongSize: spans disagree; kFrameTooLarge: beyond the
  /// layout; kBadConfig: options; kTooLarge: `planes` is full (points / min_points always
  /// suffices). O(n) for bounded iterations; no allocation.
  Status fit(const PointColumns& points, std::span<const std::uint32_t> regions,
             std::uint32_t region_count, const PointPlaneOptions& options,
             std::span<PointPlane> planes, std::uint32_t& plane_count,
             std::span<std::uint32_t> members, std::uint32_t& member_count) noexcept;

 private:
  struct Rest;
  bool find_plane(Rest& rest, const PointPlaneOptions& options, Pcg32& random,
                  PointPlane& plane) noexcept;
  void sort_by_region(std::span<const std::uint32_t> regions, std::uint32_t region_count) noexcept;
  void take_members(Rest& rest, double distance_m, PointPlane& plane,
                    std::span<std::uint32_t> members, std::uint32_t& member_count) noexcept;

  std::span<float> x_, y_, z_;           ///< of the region's points that are in no plane yet
  std::span<std::uint32_t> place_;       ///< where these come from
  std::span<std::uint32_t> by_region_;   ///< points sorted by region
  std::span<std::uint32_t> region_end_;  ///< in by_region_
};

}  // namespace planecast
