// How far apart two clouds are: nearest-point RMSE both ways (the paper's error), point to plane,
// Hausdorff, and point by point where the clouds correspond. Cold path: allocates, takes its time.
#pragma once

#include <cstddef>
#include <span>

#include "core/base/status.hpp"
#include "core/cloud/sensor_frame.hpp"

namespace planecast {

struct DistanceOptions {
  bool point_to_plane = true;  ///< d2 needs a normal for every original point, half of the time
  std::size_t normal_k = 16;   ///< neighbours (the point included) that make a normal, >= 3
};

/// Distances between an original cloud A and a decoded cloud B, all in metres.
/// Points that are not finite are skipped. Two empty clouds are 0 apart; when only one of them is
/// empty every distance is infinite.
struct CloudDistance {
  std::size_t points_a = 0;  ///< finite points of A
  std::size_t points_b = 0;  ///< finite points of B
  double d1_ab = 0;          ///< RMSE of the distance from each point of A to its nearest of B
  double d1_ba = 0;          ///< the same from B to A
  double d1 = 0;             ///< the paper's RMSE: the mean of d1_ab and d1_ba
  double d2_ab = 0;          ///< as d1_ab, of the distance along the normal at the point of A
  double d2_ba = 0;          ///< as d1_ba, along the normal at the nearest point of A
  double d2 = 0;             ///< the mean of d2_ab and d2_ba; 0 when not asked for
  double hausdorff_ab = 0;   ///< largest distance from a point of A to its nearest of B
  double hausdorff_ba = 0;   ///< the same from B to A
  double hausdorff = 0;      ///< the larger of the two
};

/// Compares two lists of points [m] given in the same frame of reference.
/// Normals are those of the original in both directions (the normal a decoder invents would flatter
/// it): PCA of the normal_k nearest points; where these span no plane (fewer than three, or all on
/// one line) the whole distance counts. O((a + b) log n), about a second for two VGA clouds.
CloudDistance cloud_distance(std::span<const Point3f> original, std::span<const Point3f> decoded,
                             const DistanceOptions& options = {});

/// Distances between points of the same index [m], for clouds whose points correspond.
struct CorrespondingDistance {
  double max = 0;                 ///< 0 when no pair has two finite points
  double rmse = 0;                ///< over the pairs compared
  std::size_t worst_index = 0;    ///< index of the pair that is `max` apart
  std::size_t compared = 0;       ///< pairs with both points finite
  std::size_t only_original = 0;  ///< pairs where only the original is finite: points lost
  std::size_t only_decoded = 0;   ///< pairs where only the decoded is finite: points invented
};

/// Compares point i of one cloud with point i of the other, in double. kWrongSize when the counts
/// differ. O(n), no allocation.
Result<CorrespondingDistance> max_corresponding(std::span<const Point3f> original,
                                                std::span<const Point3f> decoded);

}  // namespace planecast
