// Regions of smooth surface in unorganised clouds without a neighbour search: running sums of the
// points of each voxel, grown over the 26 voxels around. The fast way; point_region_growing.hpp is
// the paper's.
#pragma once

#include <cstdint>
#include <span>

#include "core/base/arena.hpp"
#include "core/base/status.hpp"
#include "core/cloud/sensor_frame.hpp"
#include "core/segment/point_region_growing.hpp"

namespace planecast {

struct VoxelRegionOptions {
  double voxel_m = 0.04;          ///< side of a voxel, at least; doubled until ...
  double points_per_voxel = 6;    ///< ... those with points hold as many on average
  double smoothness_deg = 20;     ///< most angle between the normals of voxel and region, 0..90
  double roughness = 0.08;        ///< most curvature of a voxel and its neighbours in a region
  double distance_share = 0.5;    ///< of a voxel's side: most distance of its mean from the region
  std::uint32_t min_points = 50;  ///< regions of fewer are given up; their points have none
};

/// Finds regions. One thread; memory (about 130 bytes a point) from the arena at start.
class VoxelRegions {
 public:
  void layout(Arena& arena, std::uint32_t max_points) noexcept;

  /// Sorts the usable points (finite, within +-reach) by voxel and writes their regions; regions in
  /// the order of their flattest voxel. kFrameTooLarge: beyond the layout; kBadConfig: options or
  /// reach. O(n) and the voxels sorted, about 0.2 us a point; no allocation.
  Status find(std::span<const Point3f> points, float reach, const VoxelRegionOptions& options,
              PointRegionReport& report) noexcept;

  /// Usable points of the last frame, sorted by voxel: coordinates, index in the span given to
  /// find(), and region (kNoRegion: none).
  std::uint32_t size() const noexcept { return size_; }
  std::span<const float> x() const noexcept { return x_.first(size_); }
  std::span<const float> y() const noexcept { return y_.first(size_); }
  std::span<const float> z() const noexcept { return z_.first(size_); }
  std::span<const std::uint32_t> source() const noexcept { return source_.first(size_); }
  std::span<const std::uint32_t> regions() const noexcept { return regions_.first(size_); }
  /// Side of the voxels of the last frame [m].
  double voxel_m() const noexcept { return voxel_m_; }

 private:
  /// Sums of points, of coordinates relative to the middle of voxel (0, 0, 0) of where they stand.
  struct Sums {
    float n = 0, x = 0, y = 0, z = 0, xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
  };
  struct Voxel {
    std::int32_t i = 0, j = 0, k = 0;
    std::uint32_t first = 0, count = 0;
    std::uint32_t region = 0;
    float normal[3] = {};  ///< of it and the 26 around
    float curvature = 0;
    Sums sums;
  };
  /// A growing region's plane, in double, relative to the first voxel's middle.
  struct Plane;

  std::uint32_t slot_of(std::int32_t i, std::int32_t j, std::int32_t k) const noexcept;
  std::uint32_t voxel_at(std::int32_t i, std::int32_t j, std::int32_t k) const noexcept;
  void fill_voxels(std::span<const Point3f> points, float reach) noexcept;
  void sort_points(std::span<const Point3f> points, float reach) noexcept;
  void measure_voxels() noexcept;
  std::uint32_t grow(std::uint32_t seed, const VoxelRegionOptions& options,
                     std::uint32_t region) noexcept;

  std::span<std::uint32_t> table_;  ///< open addressing: voxel + 1, 0 free
  std::span<Voxel> voxels_;
  std::span<std::uint32_t> voxel_of_;  ///< by input point
  std::span<std::uint32_t> order_;     ///< voxels by curvature; also the queue while growing
  std::span<std::uint32_t> queue_;
  std::span<float> x_, y_, z_;
  std::span<std::uint32_t> source_, regions_;
  std::uint32_t voxel_count_ = 0, size_ = 0;
  double voxel_m_ = 0;
};

}  // namespace planecast
